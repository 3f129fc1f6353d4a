#include "net/clock_filter.h"

#include <algorithm>
#include <cmath>

namespace tandem::net {
namespace {

constexpr std::int64_t kMaxAge_ns = 1'000'000'000'000'000;  // 11 days: stamps of nobody's clock

[[nodiscard]] double difference(std::int64_t a, std::int64_t b) noexcept {
  // Stamps may be anything a peer writes: subtracting as double cannot overflow. Where it matters
  // the two are close, and then the integer difference is exact.
  const double rough = static_cast<double>(a) - static_cast<double>(b);
  return std::abs(rough) < 1e18 ? static_cast<double>(a - b) : rough;
}

}  // namespace

double ClockFilter::width_now(const Exchange& exchange, std::int64_t now_ns) const noexcept {
  return exchange.half_width_ns + p_.max_skew * std::abs(difference(now_ns, exchange.arrival_ns));
}

const ClockFilter::Exchange& ClockFilter::best(std::int64_t now_ns) const noexcept {
  const auto end =
      window_.begin() + static_cast<std::ptrdiff_t>(std::min<std::uint64_t>(exchanges_, kWindow));
  return *std::min_element(window_.begin(), end, [&](const Exchange& a, const Exchange& b) {
    return width_now(a, now_ns) < width_now(b, now_ns);
  });
}

ClockAnswer ClockFilter::update(const ClockStamps& stamps) noexcept {
  if (stamps.echo_ns == 0) return ClockAnswer::kNoEcho;
  const std::int64_t t1 = stamps.echo_ns, t3 = stamps.send_ns, t4 = stamps.arrival_ns;
  const std::int64_t round_trip = (t4 - t1) - stamps.echo_hold_ns;
  if (t4 < t1 || stamps.echo_hold_ns < 0 || round_trip < 2 * p_.min_one_way)
    return ClockAnswer::kImpossible;
  const std::int64_t forth = t3 - stamps.echo_hold_ns - t1, back = t3 - t4;

  Exchange fresh;
  fresh.offset_ns = forth / 2 + back / 2 + (forth % 2 + back % 2) / 2;
  fresh.arrival_ns = t4;
  fresh.half_width_ns = 0.5 * static_cast<double>(round_trip) -
                        static_cast<double>(p_.min_one_way) +
                        p_.max_skew * static_cast<double>(t4 - t1) + 1.0;  // 1 ns of rounding

  ClockAnswer answer = ClockAnswer::kUsed;
  if (valid() && std::abs(difference(fresh.offset_ns, offset_ns())) >
                     fresh.half_width_ns + static_cast<double>(bound_ns(t4))) {
    exchanges_ = 0;
    ++restarts_;
    answer = ClockAnswer::kRestarted;
  }
  window_[exchanges_ % kWindow] = fresh;
  ++exchanges_;
  round_trip_ns_ = round_trip;

  const Exchange& target = best(t4);
  if (exchanges_ <= kWindow) {
    base_ns_ = target.offset_ns;
    fraction_ns_ = 0.0;
  } else {
    const double pause =
        std::clamp(difference(t4, last_ns_), 0.0, static_cast<double>(p_.max_pause));
    const double reach = p_.slew * pause;
    fraction_ns_ +=
        std::clamp(difference(target.offset_ns, base_ns_) - fraction_ns_, -reach, reach);
  }
  last_ns_ = std::max(last_ns_, t4);
  estimate_bound_ns_ =
      width_now(target, t4) + std::abs(difference(target.offset_ns, base_ns_) - fraction_ns_);
  return answer;
}

std::int64_t ClockFilter::offset_ns() const noexcept {
  return base_ns_ + static_cast<std::int64_t>(std::llround(fraction_ns_));
}

std::int64_t ClockFilter::bound_ns(std::int64_t now_ns) const noexcept {
  const double bound = estimate_bound_ns_ + p_.max_skew * std::abs(difference(now_ns, last_ns_));
  return static_cast<std::int64_t>(std::ceil(std::min(bound, 9e18)));
}

std::int64_t ClockFilter::age_ns(std::int64_t send_ns, std::int64_t now_ns) const noexcept {
  if (!valid()) return 0;
  const double rough = difference(now_ns, send_ns) + static_cast<double>(offset_ns());
  if (!(std::abs(rough) < 1e15)) return rough < 0.0 ? p_.min_one_way : kMaxAge_ns;
  return std::max<std::int64_t>(now_ns - send_ns + offset_ns(), p_.min_one_way);
}

}  // namespace tandem::net
