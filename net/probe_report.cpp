#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <string>
#include <vector>

#include "net/probe.h"

namespace tandem::net {
namespace {

[[nodiscard]] [[gnu::format(printf, 1, 2)]] std::string format(const char* pattern, ...) {
  char line[512];
  va_list arguments;
  va_start(arguments, pattern);
  std::vsnprintf(line, sizeof line, pattern, arguments);
  va_end(arguments);
  return line;
}

/// Equal bins from the smallest round trip to the 99.9 % one; the last takes what is above.
struct Bins {
  double from = 0.0, width = 0.0;  ///< [s]
  std::vector<std::uint64_t> count;
};

[[nodiscard]] Bins bins_of(const ProbeResult& r, int bins) {
  Bins out;
  out.count.assign(static_cast<std::size_t>(bins), 0);
  out.from = r.min;
  out.width = std::max(r.p999 - r.min, 1e-6) / (bins - 1);
  for (const double t : r.sorted) {
    const auto bin = static_cast<std::size_t>((t - out.from) / out.width);
    ++out.count[std::min(bin, out.count.size() - 1)];
  }
  return out;
}

/// For text inside an SVG.
[[nodiscard]] std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '<' || c == '>' || c == '&' || c == '"')
      out += '?';
    else
      out += c;
  }
  return out;
}

}  // namespace

std::string probe_table(const ProbeResult& r, const std::string& peer) {
  const double thesis_rate = thesis::kPackets / (60.0 * thesis::kMinutes);
  std::string t = format("Link to %s: %llu packets of %zu bytes in %.1f s%s\n\n", peer.c_str(),
                         static_cast<unsigned long long>(r.sent), r.datagram, r.seconds,
                         r.interrupted ? " (interrupted)" : "");
  const char* row = "  %-24s %-36s %s\n";
  t += format(row, "", "measured", "thesis, Table 1.1");
  const auto add = [&](const char* name, const std::string& ours, const std::string& theirs) {
    t += format(row, name, ours.c_str(), theirs.c_str());
  };
  add("Ave. round-trip delay", format("%.4f ms", 1e3 * r.mean),
      format("%.4f ms", 1e3 * thesis::kMeanRoundTrip));
  add("RMS jitter", format("%.4f ms", 1e3 * r.rms_jitter),
      format("%.4f ms", 1e3 * thesis::kRmsJitter));
  add("Packet loss",
      format("%llu packets out of %llu", static_cast<unsigned long long>(r.lost()),
             static_cast<unsigned long long>(r.sent)),
      format("%.0f packets out of %.1f million", thesis::kLost, 1e-6 * thesis::kPackets));
  add("Achieved packet rate",
      format("%.1f a second (asked %.1f)", r.achieved_rate_hz, r.asked_rate_hz),
      format("%.0f a second *", thesis::kStatedRate_hz));
  add("Duplicates, reordered",
      format("%llu, %llu", static_cast<unsigned long long>(r.duplicates),
             static_cast<unsigned long long>(r.reordered)),
      "");
  add("Jitter of RFC 3550", format("%.4f ms", 1e3 * r.jitter_rfc3550), "");
  t += format("  %-24s min %.4f  50 %% %.4f  90 %% %.4f  99 %% %.4f  99.9 %% %.4f  max %.4f\n",
              "Round trip [ms]", 1e3 * r.min, 1e3 * r.p50, 1e3 * r.p90, 1e3 * r.p99, 1e3 * r.p999,
              1e3 * r.max);
  if (r.send_failures != 0)
    t += format("  %llu packets were not taken by our own system (counted as lost)\n",
                static_cast<unsigned long long>(r.send_failures));
  t += format(
      "\n  * as printed there; but %.1f million packets in %.0f minutes are %.0f a second, not "
      "%.0f.\n",
      1e-6 * thesis::kPackets, thesis::kMinutes, thesis_rate, thesis::kStatedRate_hz);
  t += "  RMS jitter: root mean square of the deviations of the round trip from its mean.\n";
  return t;
}

std::string probe_histogram(const ProbeResult& r) {
  if (r.sorted.empty()) return "";
  const Bins bins = bins_of(r, 20);
  const auto most = *std::max_element(bins.count.begin(), bins.count.end());
  std::string t = "  round trip [ms]   packets\n";
  for (std::size_t i = 0; i < bins.count.size(); ++i) {
    const bool last = i + 1 == bins.count.size();
    // A bin that is not empty shows at least a dot.
    const auto length = static_cast<std::size_t>(
        std::lround(44.0 * static_cast<double>(bins.count[i]) / static_cast<double>(most)));
    std::string bar = length == 0 && bins.count[i] > 0 ? "." : std::string(length, '#');
    t += format("  %s %9.4f %9llu %s\n", last ? "from" : "    ",
                1e3 * (bins.from + static_cast<double>(i) * bins.width),
                static_cast<unsigned long long>(bins.count[i]), bar.c_str());
  }
  return t;
}

std::string probe_picture(const ProbeResult& r, const std::string& peer) {
  constexpr double kWidth = 800, kHeight = 420, kLeft = 60, kRight = 20, kTop = 50, kBottom = 60;
  constexpr int kBins = 60;
  std::string s = format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %.0f %.0f\" "
      "font-family=\"sans-serif\" "
      "font-size=\"13\">\n<rect width=\"100%%\" height=\"100%%\" fill=\"white\"/>\n",
      kWidth, kHeight);
  s += format("<text x=\"%.0f\" y=\"20\" font-size=\"15\">Round trip to %s</text>\n", kLeft,
              escaped(peer).c_str());
  s += format(
      "<text x=\"%.0f\" y=\"38\">%llu packets at %.0f a second, %llu lost; mean %.4f ms, RMS "
      "jitter "
      "%.4f ms, 99.9 %% %.4f ms, max %.4f ms</text>\n",
      kLeft, static_cast<unsigned long long>(r.sent), r.achieved_rate_hz,
      static_cast<unsigned long long>(r.lost()), 1e3 * r.mean, 1e3 * r.rms_jitter, 1e3 * r.p999,
      1e3 * r.max);
  const double right = kWidth - kRight, bottom = kHeight - kBottom;
  if (!r.sorted.empty()) {
    const Bins bins = bins_of(r, kBins);
    const double most =
        static_cast<double>(*std::max_element(bins.count.begin(), bins.count.end()));
    // Logarithmic heights: one packet late among a million must be seen.
    const double decades = std::log10(most) + 1.0;
    const double bin_width = (right - kLeft) / kBins;
    for (int d = 0; d < static_cast<int>(decades) + 1; ++d) {
      const double y = bottom - (bottom - kTop) * (d + 1.0 - 1.0) / decades;
      if (y < kTop) break;
      s += format("<line x1=\"%.1f\" x2=\"%.1f\" y1=\"%.1f\" y2=\"%.1f\" stroke=\"#ddd\"/>\n",
                  kLeft, right, y, y);
      s += format("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\">%g</text>\n", kLeft - 6, y + 4,
                  d == 0 ? 0.1 : std::pow(10.0, d - 1));
    }
    for (std::size_t i = 0; i < bins.count.size(); ++i) {
      if (bins.count[i] == 0) continue;
      const double height =
          (bottom - kTop) * (std::log10(static_cast<double>(bins.count[i])) + 1.0) / decades;
      s += format("<rect x=\"%.2f\" y=\"%.2f\" width=\"%.2f\" height=\"%.2f\" fill=\"%s\"/>\n",
                  kLeft + static_cast<double>(i) * bin_width, bottom - height, 0.9 * bin_width,
                  height, i + 1 == bins.count.size() ? "#c44" : "#47a");
    }
    for (int k = 0; k <= 5; ++k) {
      const double t = bins.from + k * bins.width * kBins / 5.0;
      s += format("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">%.3f</text>\n",
                  kLeft + (right - kLeft) * k / 5.0, bottom + 18, 1e3 * t);
    }
  }
  s += format("<line x1=\"%.1f\" x2=\"%.1f\" y1=\"%.1f\" y2=\"%.1f\" stroke=\"black\"/>\n", kLeft,
              right, bottom, bottom);
  s += format(
      "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">round trip [ms]; the last bar holds all "
      "above 99.9 %%; packets per bar on a logarithmic scale</text>\n",
      0.5 * (kLeft + right), bottom + 42);
  return s + "</svg>\n";
}

}  // namespace tandem::net
