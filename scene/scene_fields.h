#pragma once

#include <string_view>

#include "core/delay_line.h"
#include "core/scene.h"
#include "core/target_path.h"

/// The one list of a scene's fields: reading, writing, range check and hash all walk it. A visitor
/// has
///   value(Field, T&)                                T: double, int, bool, std::string, an enum
///   group(Field, fn(sub))                           a part
///   optional_group(Field, std::optional<T>&, fn(T&, sub))
///   list(Field, std::vector<T>&, max, fn(T&, sub))
///   where(words)                                    what kind of thing the next fields belong to
/// A field that the scene's space does not have is not visited; the reader refuses it by that.
namespace tandem::scene {

/// Name, unit and range of one field; names are those of scene.proto.
struct Field {
  std::string_view name;
  std::string_view unit{};
  double low = -1e300;
  double high = 1e300;
  bool above_low = false;  ///< low itself is not allowed
  bool local = false;      ///< not part of the shared hash

  [[nodiscard]] constexpr Field as_local() const {
    Field copy = *this;
    copy.local = true;
    return copy;
  }
  [[nodiscard]] constexpr Field named(std::string_view other) const {
    Field copy = *this;
    copy.name = other;
    return copy;
  }
};

constexpr Field plain(std::string_view name) { return {.name = name}; }
constexpr Field within(std::string_view name, std::string_view unit, double low, double high) {
  return {.name = name, .unit = unit, .low = low, .high = high};
}
constexpr Field positive(std::string_view name, std::string_view unit, double high) {
  return {.name = name, .unit = unit, .low = 0.0, .high = high, .above_low = true};
}

/// Far beyond any desk, near enough that a slip of the unit (mm for m) is caught.
inline constexpr double kMaxCoordinate = 10.0;  ///< [m]
inline constexpr double kMaxStiffness = 1e7;    ///< [N/m], [N m/rad]
inline constexpr double kMaxDamping = 1e5;      ///< [N s/m], [N m s/rad]
inline constexpr double kMaxMass = 1e6;         ///< [kg]
inline constexpr double kMaxForce = 1e4;        ///< [N]
inline constexpr double kMaxTime = 1e6;         ///< [s]
inline constexpr double kMaxFriction = 10.0;    ///< coefficient
inline constexpr int kMaxCouplers = core::kMaxObjects * core::kMaxUsers * (core::kMaxUsers + 1);

template <typename V>
void visit_vector(Field field, core::Vec3& vector, core::Space space, V& v) {
  v.group(field, [&](auto& sub) {
    sub.value(field.named("x"), vector.x);
    if (space != core::Space::kAxis) sub.value(field.named("y"), vector.y);
    if (space == core::Space::kSpace) sub.value(field.named("z"), vector.z);
  });
}

/// About z in a plane, about all three in space; an axis has none.
template <typename V>
void visit_rotation(Field field, core::Vec3& vector, core::Space space, V& v) {
  if (space == core::Space::kAxis) return;
  v.group(field, [&](auto& sub) {
    if (space == core::Space::kSpace) sub.value(field.named("x"), vector.x);
    if (space == core::Space::kSpace) sub.value(field.named("y"), vector.y);
    sub.value(field.named("z"), vector.z);
  });
}

template <typename V>
void visit_gain_values(core::Gain& gain, V& v, bool rotation = false) {
  v.value(within("stiffness", rotation ? "N m/rad" : "N/m", 0.0, kMaxStiffness), gain.stiffness);
  v.value(within("damping", rotation ? "N m s/rad" : "N s/m", 0.0, kMaxDamping), gain.damping);
}

template <typename V>
void visit_gain(Field field, core::Gain& gain, V& v, bool rotation = false) {
  v.group(field, [&](auto& sub) { visit_gain_values(gain, sub, rotation); });
}

template <typename V>
void visit_friction(core::FrictionParameters& friction, V& v) {
  v.value(within("static_friction", "", 0.0, kMaxFriction), friction.static_coefficient);
  v.value(within("dynamic_friction", "", 0.0, kMaxFriction), friction.dynamic_coefficient);
  v.value(within("threshold_velocity", "m/s", 0.0, 1.0), friction.threshold_velocity);
}

template <typename V>
void visit_object(core::ObjectParameters& o, core::Space space, V& v) {
  const bool plane = space == core::Space::kPlane, axis = space == core::Space::kAxis;
  v.value(plain("name"), o.name);
  v.value(plain("shape"), o.shape);
  if (!axis) visit_vector(within("size", "m", 0.0, kMaxCoordinate), o.size, space, v);
  if (!axis && !plane) v.value(within("radius", "m", 0.0, kMaxCoordinate), o.radius);
  v.value(positive("mass", "kg", kMaxMass), o.mass);
  visit_rotation(within("inertia", "kg m^2", 0.0, 1e8), o.inertia, space, v);
  visit_vector(within("position", "m", -kMaxCoordinate, kMaxCoordinate), o.position, space, v);
  if (plane) v.value(within("angle", "rad", -7.0, 7.0), o.angle);
  if (!axis && !plane)
    v.group(plain("orientation"), [&](auto& sub) {
      sub.value(within("w", "", -1e3, 1e3), o.orientation.w);
      sub.value(within("x", "", -1e3, 1e3), o.orientation.x);
      sub.value(within("y", "", -1e3, 1e3), o.orientation.y);
      sub.value(within("z", "", -1e3, 1e3), o.orientation.z);
    });
  visit_vector(within("velocity", "m/s", -100.0, 100.0), o.velocity, space, v);
  visit_rotation(within("angular_velocity", "rad/s", -1e3, 1e3), o.angular_velocity, space, v);
  if (axis || plane) v.value(within("ground_friction", "", 0.0, kMaxFriction), o.ground_friction);
  if (plane)
    v.value(within("ground_friction_rotation", "", 0.0, kMaxFriction), o.ground_friction_rotation);
  v.value(within("compensation", "N s/m", 0.0, 1e3), o.compensation);
  if (!axis)
    v.value(within("compensation_rotation", "N m s/rad", 0.0, 1e3), o.compensation_rotation);
}

template <typename V>
void visit_wall(core::WallParameters& w, core::Space space, V& v) {
  const bool axis = space == core::Space::kAxis;
  v.value(plain("name"), w.name);
  visit_vector(within("point", "m", -kMaxCoordinate, kMaxCoordinate), w.point, space, v);
  visit_vector(within("normal", "", -1e3, 1e3), w.normal, space, v);
  visit_gain_values(w.gain, v);
  if (!axis) visit_gain(plain("tangential"), w.tangential, v);
  if (!axis) visit_friction(w.friction, v);
  if (axis) v.value(plain("attached"), w.attached);
  v.value(plain("touches_objects"), w.touches_objects);
  v.value(plain("touches_fingers"), w.touches_fingers);
}

template <typename V>
void visit_coupler(core::CouplerParameters& c, core::Space space, V& v) {
  v.value(plain("name"), c.name);
  v.value(plain("object"), c.object);
  v.value(plain("user"), c.user);
  v.value(plain("copy"), c.copy);
  const bool plane = space == core::Space::kPlane;
  if (space == core::Space::kAxis) {
    visit_gain_values(c.gain, v);
  } else if (!c.user.empty()) {
    v.where(plane ? "a hand's coupler in a plane scene" : "a hand's coupler in a space scene");
    visit_gain(plain("normal"), c.gain, v);
    visit_gain(plain("tangential"), c.tangential, v);
  } else {
    v.where(plane ? "a coupler between copies (it names no user) in a plane scene"
                  : "a coupler between copies (it names no user) in a space scene");
    visit_gain(plain("linear"), c.gain, v);
    visit_gain(plain("rotation"), c.rotation, v, true);
  }
}

template <typename V>
void visit_sine(core::SinePart& s, std::string_view unit, core::Space space, V& v) {
  v.value(within("start", "s", -kMaxTime, kMaxTime), s.start);
  v.value(within("end", "s", -kMaxTime, 1e30), s.end);
  v.value(within("amplitude", unit, -kMaxForce, kMaxForce), s.amplitude);
  v.value(within("omega", "rad/s", -1e5, 1e5), s.omega);
  visit_vector(within("direction", "", -1e3, 1e3), s.direction, space, v);
  v.value(plain("positive_part_only"), s.positive_part_only);
}

template <typename V>
void visit_keyframe(core::Keyframe& k, core::Space space, V& v) {
  const Field offset = within("x", "m", -kMaxCoordinate, kMaxCoordinate);
  v.value(within("time", "s", 0.0, kMaxTime), k.time);
  v.value(offset, k.position.x);
  if (space != core::Space::kAxis) v.value(offset.named("y"), k.position.y);
  if (space == core::Space::kSpace) v.value(offset.named("z"), k.position.z);
}

template <typename V>
void visit_finger(core::FingerParameters& f, core::Space space, V& v) {
  v.value(plain("name"), f.name);
  v.value(plain("device").as_local(), f.device);
  visit_vector(within("position", "m", -kMaxCoordinate, kMaxCoordinate), f.position, space, v);
  if (space != core::Space::kAxis) v.value(within("radius", "m", 0.0, 1.0), f.radius);
  visit_gain(plain("hand").as_local(), f.hand, v);
  v.value(within("damping", "N s/m", 0.0, kMaxDamping).as_local(), f.damping);
  v.list(plain("path").as_local(), f.intent.path, core::kMaxKeyframes,
         [&](core::Keyframe& k, auto& sub) { visit_keyframe(k, space, sub); });
  v.list(plain("path_sine").as_local(), f.intent.path_sines, core::kMaxSines,
         [&](core::SinePart& s, auto& sub) { visit_sine(s, "m", space, sub); });
  visit_vector(within("force", "N", -kMaxForce, kMaxForce).as_local(), f.intent.force, space, v);
  v.list(plain("force_sine").as_local(), f.intent.force_sines, core::kMaxSines,
         [&](core::SinePart& s, auto& sub) { visit_sine(s, "N", space, sub); });
}

template <typename V>
void visit_user(core::UserParameters& u, core::Space space, V& v) {
  v.value(plain("name"), u.name);
  v.value(positive("mass", "kg", kMaxMass), u.mass);
  v.value(plain("local"), u.local);
  v.list(plain("finger"), u.fingers, core::kMaxFingers,
         [&](core::FingerParameters& f, auto& sub) { visit_finger(f, space, sub); });
}

template <typename V>
void visit_device(core::DeviceParameters& d, V& v) {
  v.value(plain("name"), d.name);
  v.value(plain("kind"), d.kind);
  v.value(within("max_force", "N", 0.0, kMaxForce), d.max_force);
  v.value(within("max_slew", "N/s", 0.0, 1e9), d.max_slew);
  v.value(within("encoder_step", "m", 0.0, 0.01), d.encoder_step);
  v.value(within("friction", "N", 0.0, 100.0), d.friction);
  v.value(within("velocity_cutoff_hz", "Hz", 0.0, 20000.0), d.velocity_cutoff_hz);
  v.value(plain("file"), d.file);
}

template <typename V>
void visit_contact(core::ContactParameters& c, core::Space space, V& v) {
  v.value(plain("attached"), c.attached);
  if (space == core::Space::kAxis) return;
  visit_friction(c.friction, v);
  v.value(plain("moment_cancellation"), c.moment_cancellation);
  v.value(within("pulse_force", "N", 0.0, kMaxForce), c.pulse_force);
}

[[nodiscard]] constexpr std::string_view words(core::Space space) {
  switch (space) {
    case core::Space::kAxis:
      return "an axis scene";
    case core::Space::kPlane:
      return "a plane scene";
    case core::Space::kSpace:
      return "a space scene";
  }
  return "this scene";
}

template <typename V>
void visit_scene(core::Scene& s, V& v) {
  v.value(plain("scene_version"), s.version);
  v.value(plain("name").as_local(), s.name);
  v.value(plain("description").as_local(), s.description);
  v.value(plain("space"), s.space);
  v.value(plain("architecture"), s.architecture);
  const core::Space space = s.space;
  v.where(words(space));
  v.group(plain("rates"), [&](auto& sub) {
    sub.value(within("local_hz", "Hz", 100.0, 20000.0), s.rates.local_hz);
    sub.value(within("packet_hz", "Hz", 1.0, 20000.0), s.rates.packet_hz);
    sub.value(within("latency_ticks", "ticks", 0.0, core::kMaxLatencyTicks), s.rates.latency_ticks);
  });
  v.value(plain("integrator"), s.integrator);
  v.group(plain("reconstruction"), [&](auto& sub) {
    sub.value(plain("kind"), s.reconstruction.kind);
    sub.value(within("horizon", "s", 0.0, 10.0), s.reconstruction.horizon);
    sub.value(positive("decay", "s", 10.0), s.reconstruction.decay);
  });
  v.optional_group(plain("silence"), s.silence, [](core::SilenceParameters& silence, auto& sub) {
    sub.value(positive("timeout", "s", 60.0), silence.timeout);
    sub.value(within("fade", "s", 0.0, 60.0), silence.fade);
    sub.value(within("rejoin", "s", 0.0, 60.0), silence.rejoin);
  });
  v.group(plain("contact"), [&](auto& sub) { visit_contact(s.contact, space, sub); });
  v.value(within("gravity", "m/s^2", 0.0, 100.0), s.gravity);
  if (space == core::Space::kSpace) v.value(plain("weight"), s.weight);
  v.list(plain("object"), s.objects, core::kMaxObjects,
         [&](core::ObjectParameters& o, auto& sub) { visit_object(o, space, sub); });
  v.list(plain("wall"), s.walls, core::kMaxWalls,
         [&](core::WallParameters& w, auto& sub) { visit_wall(w, space, sub); });
  v.list(plain("coupler"), s.couplers, kMaxCouplers,
         [&](core::CouplerParameters& c, auto& sub) { visit_coupler(c, space, sub); });
  v.list(plain("user"), s.users, core::kMaxUsers,
         [&](core::UserParameters& u, auto& sub) { visit_user(u, space, sub); });
  v.list(plain("device").as_local(), s.devices, core::kMaxUsers * core::kMaxFingers,
         [](core::DeviceParameters& d, auto& sub) { visit_device(d, sub); });
}

/// How a list's entry is addressed: by its name, by its number where it has none.
template <typename T>
[[nodiscard]] std::string entry_key(const T& entry, std::size_t index) {
  if constexpr (requires { entry.name; })
    if (!entry.name.empty()) return entry.name;
  return std::to_string(index);
}

}  // namespace tandem::scene
