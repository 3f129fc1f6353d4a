#include "devices/recorded_path.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace tandem::devices {
namespace {

bool is_finite(const PathSample& s) {
  return std::isfinite(s.time) && std::isfinite(s.position.x) && std::isfinite(s.position.y) &&
         std::isfinite(s.position.z);
}

void check(const std::vector<PathSample>& samples) {
  if (samples.size() < 2) {
    throw std::invalid_argument("a recorded path has " + std::to_string(samples.size()) +
                                " samples, needs at least 2");
  }
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (!is_finite(samples[i])) {
      throw std::invalid_argument("sample " + std::to_string(i + 1) +
                                  " of a recorded path is not finite");
    }
    if (i > 0 && !(samples[i].time > samples[i - 1].time)) {
      throw std::invalid_argument("time must increase from sample to sample: sample " +
                                  std::to_string(i + 1) + " is at " +
                                  std::to_string(samples[i].time) + " s, the one before at " +
                                  std::to_string(samples[i - 1].time) + " s");
    }
  }
}

Vec3 secant(const PathSample& a, const PathSample& b) {
  return (b.position - a.position) / (b.time - a.time);
}

}  // namespace

RecordedPath::RecordedPath(std::vector<PathSample> samples, Interpolation interpolation,
                           PathEnd end, double seam)
    : samples_(std::move(samples)), end_(end), seam_(end == PathEnd::kLoop ? seam : 0.0) {
  check(samples_);
  const double start = samples_.front().time;
  for (PathSample& sample : samples_) sample.time -= start;
  if (!(seam_ >= 0.0 && seam_ <= 0.5 * length())) {
    throw std::invalid_argument("seam is " + std::to_string(seam_) + " s, must be within [0, " +
                                std::to_string(0.5 * length()) +
                                "] s, half the length of the recording");
  }
  if (interpolation == Interpolation::kLinear) return;
  const std::size_t last = samples_.size() - 1;
  slopes_.resize(samples_.size());
  slopes_.front() = secant(samples_[0], samples_[1]);
  slopes_.back() = secant(samples_[last - 1], samples_[last]);
  for (std::size_t i = 1; i < last; ++i) {
    const double before = samples_[i].time - samples_[i - 1].time;
    const double after = samples_[i + 1].time - samples_[i].time;
    slopes_[i] = (secant(samples_[i - 1], samples_[i]) * after +
                  secant(samples_[i], samples_[i + 1]) * before) /
                 (before + after);
  }
}

RecordedPath::Motion RecordedPath::at(double time) const noexcept {
  if (end_ == PathEnd::kHold || time < lap()) return within(time);
  const double t = std::fmod(time, lap());  // exact
  if (t >= seam_) return within(t);
  // The end of the lap before fades out while this one fades in; smooth in value and slope.
  const double s = t / seam_;
  const double in = s * s * (3.0 - 2.0 * s), rate = 6.0 * s * (1.0 - s) / seam_;
  const Motion now = within(t), before = within(t + lap());
  return {before.position + (now.position - before.position) * in,
          before.velocity + (now.velocity - before.velocity) * in +
              (now.position - before.position) * rate};
}

RecordedPath::Motion RecordedPath::within(double time) const noexcept {
  if (!(time >= 0.0)) return {samples_.front().position, Vec3{0.0}};
  if (time >= length()) return {samples_.back().position, Vec3{0.0}};
  const auto next = std::upper_bound(samples_.begin(), samples_.end(), time,
                                     [](double t, const PathSample& s) { return t < s.time; });
  const auto i = static_cast<std::size_t>(next - samples_.begin()) - 1;
  const PathSample& a = samples_[i];
  const PathSample& b = samples_[i + 1];
  const double h = b.time - a.time;
  const double s = (time - a.time) / h;
  const Vec3 step = b.position - a.position;
  if (slopes_.empty()) return {a.position + step * s, step / h};
  // Cubic with these values and slopes at both ends, in powers of s.
  const Vec3 c1 = slopes_[i] * h;
  const Vec3 c2 = step * 3.0 - (slopes_[i] * 2.0 + slopes_[i + 1]) * h;
  const Vec3 c3 = (slopes_[i] + slopes_[i + 1]) * h - step * 2.0;
  return {a.position + ((c3 * s + c2) * s + c1) * s, ((c3 * (3.0 * s) + c2 * 2.0) * s + c1) / h};
}

}  // namespace tandem::devices
