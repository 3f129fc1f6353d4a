#include "scene/validate_scene.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <string>
#include <tuple>

#include "scene/nearest_name.h"
#include "scene/range_checker.h"

namespace tandem::scene {
namespace {

using core::Architecture;
using core::Scene;

class Validator {
 public:
  Validator(const Scene& scene, std::vector<Problem>& problems)
      : scene_(scene), problems_(problems) {}

  void check() {
    check_version();
    check_rates();
    check_silence();
    check_contact();
    check_names("object", scene_.objects);
    check_names("wall", scene_.walls);
    check_names("coupler", scene_.couplers);
    check_names("user", scene_.users);
    check_names("device", scene_.devices);
    check_walls();
    check_couplers();
    check_users();
    check_devices();
  }

 private:
  void report(const std::string& path, const std::string& text) {
    problems_.push_back({path, path + text, {}});
  }

  template <typename T>
  static std::vector<std::string> names(const std::vector<T>& entries) {
    std::vector<std::string> out;
    for (const T& entry : entries) out.push_back(entry.name);
    return out;
  }

  /// Names are part of paths and command lines: letters, digits, '_', '-'.
  template <typename T>
  void check_names(const std::string& path, const std::vector<T>& entries) {
    std::map<std::string, int> seen;
    for (std::size_t i = 0; i < entries.size(); ++i) {
      const std::string& name = entries[i].name;
      const std::string here = path + "." + entry_key(entries[i], i);
      const bool letters = std::all_of(name.begin(), name.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
               c == '_' || c == '-';
      });
      if (name.empty())
        report(here, ": has no name; give it one (name: \"...\")");
      else if (!letters || name.size() > 32)
        report(here, ": the name '" + name + "' must be 1 to 32 letters, digits, _ or -");
      if (!name.empty() && ++seen[name] == 2)
        report(here, ": the name '" + name + "' is given twice; every " +
                         path.substr(path.rfind('.') + 1) + " needs its own");
    }
  }

  void check_version() {
    if (scene_.version != kSceneVersion)
      report("scene_version", " = " + std::to_string(scene_.version) +
                                  ": this program reads version " + std::to_string(kSceneVersion));
  }

  void check_rates() {
    const double local = scene_.rates.local_hz, packet = scene_.rates.packet_hz;
    if (!(local > 0.0) || !(packet > 0.0) || !std::isfinite(local) || !std::isfinite(packet))
      return;  // the range check says it
    if (packet > local)
      report("rates.packet_hz", " = " + number_text(packet) +
                                    " Hz: must be at most rates.local_hz = " + number_text(local) +
                                    " Hz");
  }

  void check_silence() {
    if (!scene_.silence || !(scene_.rates.packet_hz > 0.0)) return;
    const double least = 2.0 / scene_.rates.packet_hz;
    if (scene_.silence->timeout < least)
      report("silence.timeout", " = " + number_text(scene_.silence->timeout) +
                                    " s: must be at least two packet periods, " +
                                    number_text(least) + " s, or every packet comes too late");
  }

  void check_cone(const std::string& path, const core::FrictionParameters& friction) {
    if (friction.dynamic_coefficient > friction.static_coefficient)
      report(path + ".dynamic_friction",
             " = " + number_text(friction.dynamic_coefficient) +
                 ": must be at most static_friction = " + number_text(friction.static_coefficient));
  }

  void check_contact() {
    check_cone("contact", scene_.contact.friction);
    if (scene_.contact.moment_cancellation && !(scene_.contact.pulse_force > 0.0))
      report("contact.pulse_force", " = " + number_text(scene_.contact.pulse_force) +
                                        " N: moment_cancellation needs a pulse force above 0");
  }

  void check_walls() {
    for (std::size_t i = 0; i < scene_.walls.size(); ++i)
      check_cone("wall." + entry_key(scene_.walls[i], i), scene_.walls[i].friction);
  }

  bool known_user(const std::string& name) const { return core::index_of(scene_.users, name) >= 0; }

  void check_coupler(const core::CouplerParameters& c, const std::string& path) {
    const bool copies = scene_.architecture == Architecture::kDistributed ||
                        scene_.architecture == Architecture::kDistributedSplit;
    if (core::index_of(scene_.objects, c.object) < 0)
      report(path + ".object", " = '" + c.object + "': no object has this name" +
                                   suggestion(c.object, names(scene_.objects)));
    if (!c.user.empty() && !known_user(c.user))
      report(path + ".user", " = '" + c.user + "': no user has this name" +
                                 suggestion(c.user, names(scene_.users)));
    if (c.user.empty() && !copies)
      report(path + ".user",
             " is missing: only a distributed scene has couplers between copies; name the user "
             "whose hand acts");
    if (!c.copy.empty() && !copies)
      report(path + ".copy",
             " = '" + c.copy + "': copies exist only in distributed scenes; leave it out");
    if (copies && c.copy.empty())
      report(path + ".copy", " is missing: name the user whose copy it acts on" +
                                 suggestion("", names(scene_.users)));
    if (copies && !c.copy.empty() && !known_user(c.copy))
      report(path + ".copy", " = '" + c.copy + "': no user has this name" +
                                 suggestion(c.copy, names(scene_.users)));
    if (scene_.architecture == Architecture::kDistributedSplit && !c.user.empty() &&
        c.user != c.copy)
      report(path + ".user", " = '" + c.user +
                                 "': in a DISTRIBUTED_SPLIT scene a hand acts on its "
                                 "own copy only; copy must be '" +
                                 c.user + "'");
  }

  void check_couplers() {
    std::map<std::tuple<std::string, std::string, std::string>, std::string> pairs;
    for (std::size_t i = 0; i < scene_.couplers.size(); ++i) {
      const auto& c = scene_.couplers[i];
      const std::string path = "coupler." + entry_key(c, i);
      check_coupler(c, path);
      const auto [first, fresh] = pairs.try_emplace({c.object, c.user, c.copy}, c.name);
      if (!fresh)
        report(path, ": joins the same object, user and copy as coupler '" + first->second +
                         "'; take one away");
    }
    const auto demand = [&](const std::string& object, const std::string& user,
                            const std::string& copy, const std::string& what) {
      if (!pairs.contains({object, user, copy}))
        report("coupler", ": none " + what + " object '" + object +
                              "'; add one (all gains 0 if it shall do nothing)");
    };
    for (const auto& object : scene_.objects)
      for (const auto& user : scene_.users) demand_couplers(object.name, user.name, demand);
  }

  template <typename Demand>
  void demand_couplers(const std::string& object, const std::string& user, const Demand& demand) {
    const std::string own = "user '" + user + "'";
    switch (scene_.architecture) {
      case Architecture::kSingle:
      case Architecture::kCentral:
        demand(object, user, "", "joins the hand of " + own + " to");
        return;
      case Architecture::kDistributed:
        for (const auto& other : scene_.users)
          demand(object, other.name, user,
                 "joins the hand of user '" + other.name + "' to the copy at " + own + " of");
        break;
      case Architecture::kDistributedSplit:
        demand(object, user, user, "joins the hand of " + own + " to its own copy of");
        break;
    }
    demand(object, "", user, "holds the copy at " + own + " to the others of");
  }

  void check_users() {
    const std::size_t count = scene_.users.size();
    const bool single = scene_.architecture == Architecture::kSingle;
    const bool central = scene_.architecture == Architecture::kCentral;
    if (single && count != 1)
      report("user", ": " + std::to_string(count) + " users, a SINGLE scene has 1");
    else if (!single && count < (central ? 1U : 2U))
      report("user", ": " + std::to_string(count) + " users, " +
                         (central ? "a CENTRAL scene has 1 to " : "a distributed scene has 2 to ") +
                         std::to_string(core::kMaxUsers));
    const bool wall_to_touch =
        std::any_of(scene_.walls.begin(), scene_.walls.end(),
                    [](const core::WallParameters& w) { return w.touches_fingers; });
    if (scene_.objects.empty() && (!wall_to_touch || !single))
      report("object", single ? ": none, and no wall touches fingers: there is nothing to feel"
                              : ": none; users share at least one object");
    for (std::size_t i = 0; i < count; ++i)
      check_user(scene_.users[i], "user." + entry_key(scene_.users[i], i));
  }

  void check_user(const core::UserParameters& user, const std::string& path) {
    if (user.local && scene_.architecture != Architecture::kCentral)
      report(path + ".local", " = true: only a CENTRAL scene has a server to sit at");
    if (user.fingers.empty()) report(path + ".finger", ": none; a user has 1 to 4 fingers");
    check_names(path + ".finger", user.fingers);
    for (std::size_t f = 0; f < user.fingers.size(); ++f) {
      const auto& finger = user.fingers[f];
      const std::string here = path + ".finger." + entry_key(finger, f);
      check_device_of(finger, here);
      check_path(finger.intent.path, here + ".path");
      check_sines(finger.intent.path_sines, here + ".path_sine");
      check_sines(finger.intent.force_sines, here + ".force_sine");
    }
  }

  void check_device_of(const core::FingerParameters& finger, const std::string& path) {
    if (finger.device.empty()) return;
    const int d = core::index_of(scene_.devices, finger.device);
    if (d < 0) {
      report(path + ".device", " = '" + finger.device + "': no device has this name" +
                                   suggestion(finger.device, names(scene_.devices)));
      return;
    }
    const auto [first, fresh] = holder_.try_emplace(finger.device, path);
    if (!fresh)
      report(path + ".device", " = '" + finger.device + "': already held by " + first->second +
                                   "; every finger needs its own device");
    const double limit = scene_.devices[static_cast<std::size_t>(d)].max_force;
    if (scene_.contact.moment_cancellation && limit > 0.0 && scene_.contact.pulse_force > limit)
      report("contact.pulse_force", " = " + number_text(scene_.contact.pulse_force) +
                                        " N: must be at most max_force = " + number_text(limit) +
                                        " N of device '" + finger.device + "'");
  }

  void check_path(const std::vector<core::Keyframe>& keyframes, const std::string& path) {
    for (std::size_t i = 1; i < keyframes.size(); ++i)
      if (!(keyframes[i].time > keyframes[i - 1].time))
        report(path + "." + std::to_string(i) + ".time",
               " = " + number_text(keyframes[i].time) + " s: must be later than the one before, " +
                   number_text(keyframes[i - 1].time) + " s");
  }

  void check_sines(const std::vector<core::SinePart>& sines, const std::string& path) {
    for (std::size_t i = 0; i < sines.size(); ++i)
      if (!(sines[i].end > sines[i].start))
        report(path + "." + std::to_string(i) + ".end",
               " = " + number_text(sines[i].end) +
                   " s: must be later than start = " + number_text(sines[i].start) + " s");
  }

  void check_devices() {
    for (std::size_t i = 0; i < scene_.devices.size(); ++i) {
      const auto& device = scene_.devices[i];
      const std::string path = "device." + entry_key(device, i);
      const bool recorded = device.kind == core::DeviceKind::kRecorded;
      if (recorded && device.file.empty())
        report(path + ".file", " is missing: a RECORDED device plays a file; name it");
      if (!recorded && !device.file.empty())
        report(path + ".file", " = '" + device.file + "': only a RECORDED device plays a file");
      if (device.velocity_cutoff_hz >= scene_.rates.local_hz / 2.0)
        report(path + ".velocity_cutoff_hz", " = " + number_text(device.velocity_cutoff_hz) +
                                                 " Hz: must be below half of rates.local_hz, " +
                                                 number_text(scene_.rates.local_hz / 2.0) + " Hz");
    }
  }

  const Scene& scene_;
  std::vector<Problem>& problems_;
  std::map<std::string, std::string> holder_;  ///< device name to the finger that holds it
};

}  // namespace

std::vector<Problem> validate_scene(const Scene& scene) {
  std::vector<Problem> problems;
  Scene copy = scene;  // the list of fields is written for readers, too
  RangeChecker ranges("", problems);
  visit_scene(copy, ranges);
  Validator(scene, problems).check();
  validate_geometry(scene, problems);
  return problems;
}

}  // namespace tandem::scene
