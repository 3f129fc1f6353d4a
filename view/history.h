#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <deque>
#include <string>
#include <vector>

#include <glm/geometric.hpp>

#include "core/fault.h"
#include "view/snapshot.h"

namespace tandem::view {

/// A quantity over the last seconds.
struct Series {
  struct Point {
    double time = 0.0, value = 0.0;
  };
  std::string name;
  int colour_of = -1;  ///< site whose colour it has; -1: neutral
  std::deque<Point> points;

  void add(double time, double value, double span) {
    if (!points.empty() && time < points.back().time) points.clear();  // scrubbed back
    points.push_back({time, value});
    while (!points.empty() && points.front().time < time - span) points.pop_front();
  }
};

/// Everything the panels show, gathered from the snapshots on the viewer's own thread.
class History {
 public:
  static constexpr double kSpan = 8.0;  ///< [s]

  explicit History(const core::Scene& scene) {
    const int users = static_cast<int>(scene.users.size());
    for (int u = 0; u < users; ++u) {
      const std::string name = scene.users[static_cast<std::size_t>(u)].name;
      for (auto* list : {&force, &delay, &loss}) list->push_back({name, u, {}});
      fingers_.push_back(static_cast<int>(scene.users[static_cast<std::size_t>(u)].fingers.size()));
    }
    for (const char* axis : {"x", "y", "z"}) position.push_back({axis, -1, {}});
    gap.push_back({"gap", -1, {}});
    lateness.push_back({"late", -1, {}});
  }

  void add(const Snapshot& s) {
    const double t = s.time;
    const Site& own = s.sites[static_cast<std::size_t>(s.own)];
    double widest = -1.0;  // there is no other copy
    for (int i = 0; i < kSites; ++i) {
      const Site& site = s.sites[static_cast<std::size_t>(i)];
      if (i != s.own && site.has_objects && own.has_objects)
        widest = std::max(widest, replica_gap(own, site, 0));
      if (i >= static_cast<int>(fingers_.size()) || !site.has_hand) continue;
      const auto u = static_cast<std::size_t>(i);
      double most = 0.0;
      for (int f = 0; f < fingers_[u]; ++f)
        most = std::max(most, glm::length(site.fingers[static_cast<std::size_t>(f)].force));
      if (site.forces_known) force[u].add(t, most, kSpan);
      if (i != s.own && site.age > 0.0) {
        delay[u].add(t, 1e3 * site.age, kSpan);
        loss[u].add(t, 100.0 * site.loss, kSpan);
      }
    }
    if (own.has_objects)
      for (int a = 0; a < 3; ++a)
        position[static_cast<std::size_t>(a)].add(t, 1e3 * own.objects[0].p[a], kSpan);
    if (widest >= 0.0) gap[0].add(t, 1e3 * widest, kSpan);
    lateness[0].add(t, 1e6 * s.lateness, kSpan);
    note_faults(s);
    note_silence(s);
  }

  std::vector<Series> force, position, gap, lateness, delay, loss;
  std::deque<std::string> news;  ///< newest last; faults and messages
  void tell(const std::string& text) {
    news.push_back(text);
    while (news.size() > 8) news.pop_front();
  }

 private:
  /// A fault is news when it was not there for a second.
  void note_faults(const Snapshot& s) {
    static constexpr std::array<const char*, 7> kNames{"a tick ended after its deadline",
                                                       "device read failed",
                                                       "a peer is silent: its force fades",
                                                       "a number was not finite",
                                                       "force cut at the limit",
                                                       "force held back by the slew limit",
                                                       "device write failed"};
    for (std::size_t b = 0; b < kNames.size(); ++b) {
      if ((s.faults >> b & 1u) == 0) continue;
      if (s.time - last_[b] > 1.0 || s.time < last_[b]) {
        char when[32];
        std::snprintf(when, sizeof when, "%.1f s  ", s.time);
        tell(when + std::string(kNames[b]));
      }
      last_[b] = s.time;
    }
    if (s.missed > missed_) {
      char text[64];
      std::snprintf(text, sizeof text, "%.1f s  %lld ticks missed so far", s.time,
                    static_cast<long long>(s.missed));
      if (s.time - last_missed_ > 1.0) tell(text);
      last_missed_ = s.time;
    }
    missed_ = s.missed;
  }

  /// A peer that is gone, and one that is back.
  void note_silence(const Snapshot& s) {
    constexpr double kSilent = 0.5;  // [s]
    for (std::size_t u = 0; u < delay.size(); ++u) {
      const bool silent = static_cast<int>(u) != s.own && s.sites[u].age > kSilent;
      if (silent != silent_[u])
        tell("user " + delay[u].name + (silent ? " is silent" : " is back"));
      silent_[u] = silent;
    }
  }

  std::array<bool, core::kMaxUsers> silent_{};
  std::vector<int> fingers_;
  std::array<double, 7> last_{-9, -9, -9, -9, -9, -9, -9};
  double last_missed_ = -9;
  std::int64_t missed_ = 0;
};

}  // namespace tandem::view
