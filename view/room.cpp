#include "view/room.h"

#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <nlohmann/json.hpp>

namespace tandem::view {
namespace {

using Json = nlohmann::json;

/// Reads one file; knows where it is, for the words of an error.
class RoomReader {
 public:
  explicit RoomReader(std::string name) : name_(std::move(name)) {}

  [[noreturn]] void fail(const std::string& field, const std::string& what) const {
    throw std::runtime_error("room " + name_ + ": field " + field + ": " + what);
  }

  [[nodiscard]] double number(const Json& j, const std::string& field) const {
    if (!j.is_number() || !std::isfinite(j.get<double>()))
      fail(field, j.dump() + " is not a number");
    return j.get<double>();
  }

  [[nodiscard]] Vec3 vector(const Json& j, const std::string& field) const {
    if (!j.is_array() || j.size() != 3) fail(field, j.dump() + " is not [x, y, z] in metres");
    Vec3 v{0.0};
    for (int i = 0; i < 3; ++i) {
      v[i] = number(j[static_cast<std::size_t>(i)], field);
      if (std::abs(v[i]) > 100.0) fail(field, j.dump() + ": metres, at most 100");
    }
    return v;
  }

  /// {"translation": [x,y,z], "rotation": [w,x,y,z]}, or {"pairs": [{"here": .., "common": ..}]}.
  [[nodiscard]] Rigid rigid(const Json& j, const std::string& field, double& worst) const {
    if (!j.is_object()) fail(field, "is no object with translation and rotation, or pairs");
    if (j.contains("pairs")) return fitted(j["pairs"], field + ".pairs", worst);
    Rigid r;
    if (j.contains("translation")) r.t = vector(j["translation"], field + ".translation");
    if (j.contains("rotation")) {
      const Json& q = j["rotation"];
      if (!q.is_array() || q.size() != 4)
        fail(field + ".rotation", q.dump() + " is not a quaternion [w, x, y, z]");
      r.q =
          Quat(number(q[0], field), number(q[1], field), number(q[2], field), number(q[3], field));
      const double length = std::sqrt(glm::dot(r.q, r.q));
      if (std::abs(length - 1.0) > 0.01)
        fail(field + ".rotation",
             q.dump() + " has length " + std::to_string(length) + "; a rotation has length 1");
      r.q = glm::normalize(r.q);
    }
    return r;
  }

 private:
  /// The rigid motion that brings the points of one frame onto the same points in the common one,
  /// least squares (Umeyama, without scale).
  [[nodiscard]] Rigid fitted(const Json& pairs, const std::string& field, double& worst) const {
    if (!pairs.is_array() || pairs.size() < 3)
      fail(field, "needs three pairs of points or more, not on one line");
    const auto n = static_cast<Eigen::Index>(pairs.size());
    Eigen::Matrix3Xd here(3, n), common(3, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const Json& pair = pairs[static_cast<std::size_t>(i)];
      const std::string at = field + "[" + std::to_string(i) + "]";
      if (!pair.is_object() || !pair.contains("here") || !pair.contains("common"))
        fail(at, "is not {\"here\": [x,y,z], \"common\": [x,y,z]}");
      const Vec3 a = vector(pair["here"], at + ".here"), b = vector(pair["common"], at + ".common");
      here.col(i) << a.x, a.y, a.z;
      common.col(i) << b.x, b.y, b.z;
    }
    const Eigen::Vector3d middle = here.rowwise().mean();
    const Eigen::Matrix3Xd off_middle = here.colwise() - middle;
    const Eigen::Vector3d squares =  // of the extents along the principal axes, ascending
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(off_middle * off_middle.transpose(),
                                                       Eigen::EigenvaluesOnly)
            .eigenvalues();
    if (squares(1) < 1e-6 * squares(2) || squares(2) <= 0.0)
      fail(field, "all points are on one line: the rotation around it is not known");
    const Eigen::Matrix4d m = Eigen::umeyama(here, common, false);
    const Eigen::Quaterniond q(Eigen::Matrix3d(m.topLeftCorner<3, 3>()));
    const Rigid r{{m(0, 3), m(1, 3), m(2, 3)}, Quat(q.w(), q.x(), q.y(), q.z())};
    for (Eigen::Index i = 0; i < n; ++i) {
      const Vec3 off =
          r({here(0, i), here(1, i), here(2, i)}) - Vec3{common(0, i), common(1, i), common(2, i)};
      worst = std::max(worst, std::sqrt(glm::dot(off, off)));
    }
    return r;
  }

  std::string name_;
};

}  // namespace

std::map<std::string, Rigid> Room::scene_from_devices() const {
  std::map<std::string, Rigid> all;
  for (const auto& [name, frame] : common_from_device)
    all[name] = common_from_scene.inverse() * frame;
  return all;
}

Vec3 Room::eye_in_screen(Eye eye) const {
  const double side = eye == Eye::kLeft ? -0.5 : eye == Eye::kRight ? 0.5 : 0.0;
  const Rigid common_from_head = common_from_tracker * tracker_from_head;
  return common_from_screen.inverse()(common_from_head({side * eye_separation, 0.0, 0.0}));
}

Picture Room::picture(Eye eye, int width, int height) const {
  const Vec3 e = eye_in_screen(eye);
  const Rigid screen_from_scene = common_from_screen.inverse() * common_from_scene;
  Picture p;
  p.width = width;
  p.height = height;
  // The eye's frame is the screen's, moved to the eye: the picture does not turn with the head.
  p.view = glm::translate(Mat4(1.0), screen_from_scene.t - e) * glm::mat4_cast(screen_from_scene.q);
  p.projection = projection_matrix(off_axis_frustum(screen_width, screen_height, e, near, far));
  return p;
}

Room parse_room(const std::string& json, const std::string& name) {
  const RoomReader read(name);
  Json j;
  try {
    j = Json::parse(json, nullptr, true, true);
  } catch (const Json::parse_error& e) {
    throw std::runtime_error("room " + name + ": not JSON: " + e.what());
  }
  if (!j.is_object()) throw std::runtime_error("room " + name + ": is not a JSON object");
  Room room;
  bool screen = false;
  for (const auto& [key, value] : j.items()) {
    if (key == "common_from_scene") {
      room.common_from_scene = read.rigid(value, key, room.worst_residual);
    } else if (key == "common_from_tracker") {
      room.common_from_tracker = read.rigid(value, key, room.worst_residual);
    } else if (key == "common_from_device") {
      if (!value.is_object()) read.fail(key, "is no object: one entry a device");
      for (const auto& [device, frame] : value.items())
        room.common_from_device[device] =
            read.rigid(frame, key + "." + device, room.worst_residual);
    } else if (key == "screen") {
      screen = true;
      room.common_from_screen = read.rigid(value, key, room.worst_residual);
      for (const auto& [field, size] :
           {std::pair{"width", &room.screen_width}, std::pair{"height", &room.screen_height}}) {
        if (!value.contains(field)) read.fail(std::string("screen.") + field, "is missing [m]");
        *size = read.number(value[field], std::string("screen.") + field);
        if (!(*size > 0.0 && *size <= 100.0))
          read.fail(std::string("screen.") + field,
                    value[field].dump() + ": above 0 and at most 100 m");
      }
    } else if (key == "tracker_from_head") {
      room.tracker_from_head = read.rigid(value, key, room.worst_residual);
    } else if (key == "eye_separation") {
      room.eye_separation = read.number(value, key);
      if (room.eye_separation < 0.0 || room.eye_separation > 1.0)
        read.fail(key, value.dump() + ": 0 to 1 m");
    } else {
      read.fail(key,
                "is not known; allowed are common_from_scene, common_from_tracker, "
                "common_from_device, screen, tracker_from_head, eye_separation");
    }
  }
  if (!screen) read.fail("screen", "is missing: width, height [m], translation, rotation");
  (void)room.picture(Eye::kMiddle, 16, 9);  // an eye behind the screen is refused here
  return room;
}

Room load_room(const std::string& file) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error("room " + file + ": cannot be read");
  std::ostringstream text;
  text << in.rdbuf();
  return parse_room(text.str(), file);
}

Vec3 parse_point(const std::string& text) {
  Vec3 p{0.0};
  std::istringstream in(text);
  char comma = ',', comma2 = ',';
  std::string rest;
  if (!(in >> p.x >> comma >> p.y >> comma2 >> p.z) || comma != ',' || comma2 != ',' ||
      (in >> rest) || !std::isfinite(p.x + p.y + p.z))
    throw std::invalid_argument("\"" + text + "\" is not X,Y,Z in metres");
  return p;
}

}  // namespace tandem::view
