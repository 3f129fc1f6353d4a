#include "view/recording_source.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "scene/load_scene.h"

namespace tandem::view {
namespace {

constexpr std::uint64_t kBlock = 4096;

}  // namespace

RecordingSource::RecordingSource(const std::string& file)
    : reader_(file), scene_(scene::load_scene_text(reader_.header().scene_text, file)) {
  for (std::uint64_t first = 0; first < reader_.tick_count();) {
    const auto ticks = reader_.ticks(first, kBlock);
    if (ticks.empty()) break;
    for (const core::TickRecord& tick : ticks) slots_.push_back(tick.slot);
    first += ticks.size();
  }
  if (slots_.empty())
    throw std::runtime_error("recording " + file + " has no ticks: there is nothing to see");
  for (std::uint64_t first = 0; first < reader_.packet_count();) {
    const auto packets = reader_.packets(first, kBlock);
    if (packets.empty()) break;
    for (std::size_t i = 0; i < packets.size(); ++i)
      if (packets[i].peer < core::kMaxUsers)
        packets_[packets[i].peer].push_back({packets[i].slot, first + i});
    first += packets.size();
  }
  assembler_ = std::make_unique<Assembler>(scene_, reader_.header().user);
}

const std::string& RecordingSource::user() const { return reader_.header().user; }

const Snapshot& RecordingSource::at(double time) {
  const auto slot = static_cast<std::int64_t>(std::floor(time * scene_.rates.local_hz + 1e-6));
  const auto after = std::upper_bound(slots_.begin(), slots_.end(), slot);
  const auto tick =
      static_cast<std::size_t>(std::max<std::ptrdiff_t>(after - slots_.begin() - 1, 0));
  if (tick == tick_) return now_;
  if (tick_ == SIZE_MAX || tick < tick_) assembler_->forget();
  const std::size_t before = tick_;
  tick_ = tick;
  for (const auto& places : packets_) {
    const auto next =
        std::upper_bound(places.begin(), places.end(), slots_[tick],
                         [](std::int64_t s, const PacketPlace& p) { return s < p.slot; });
    if (next == places.begin()) continue;
    const auto packets = reader_.packets(std::prev(next)->index, 1);
    for (const core::PacketRecord& packet : packets)
      assembler_->take(packet, next - places.begin());
  }
  // The worst and all of the ticks that are passed over count, so that a plot shows them.
  const std::size_t skipped = before < tick ? std::min<std::size_t>(tick - before, 256) : 1;
  std::int64_t worst = 0;
  std::uint32_t faults = 0;
  const auto ticks = reader_.ticks(tick + 1 - skipped, skipped);
  for (const core::TickRecord& t : ticks) {
    worst = std::max(worst, t.woke_ns - t.due_ns);
    faults |= t.faults;
  }
  if (ticks.empty()) return now_;
  assembler_->take(ticks.back());
  now_ = assembler_->snapshot();
  now_.lateness = 1e-9 * static_cast<double>(worst);
  now_.faults = faults;
  now_.missed = slots_[tick] - slots_.front() - static_cast<std::int64_t>(tick);
  return now_;
}

}  // namespace tandem::view
