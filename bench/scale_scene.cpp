#include "bench/scale_scene.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

namespace tandem::bench {
namespace {

using core::CouplerParameters;
using core::Scene;

constexpr double kApart = 0.12;  // of box centres [m]; fingers start 3.5 cm from a centre

void check(const Scene& scene, const ScaleSize& size) {
  const bool fits = scene.space == core::Space::kPlane && scene.users.size() == 2 &&
                    scene.objects.size() == 1 &&
                    (scene.architecture == core::Architecture::kCentral ||
                     scene.architecture == core::Architecture::kDistributed);
  if (!fits)
    throw std::invalid_argument("scene " + scene.name +
                                ": only a planar one, CENTRAL or DISTRIBUTED, of two users and one "
                                "object can be grown; box_central and box_distributed are");
  if (size.users < 2 || size.objects < 1)
    throw std::invalid_argument("a scene of " + std::to_string(size.users) + " users and " +
                                std::to_string(size.objects) + " objects; at least 2 and 1");
}

/// The coupler of a user (empty: of copies) on a copy (empty: the server's object).
const CouplerParameters& coupler(const Scene& scene, const std::string& user,
                                 const std::string& copy) {
  for (const CouplerParameters& c : scene.couplers)
    if (c.user == user && c.copy == copy) return c;
  throw std::invalid_argument("scene " + scene.name + " has no coupler of user '" + user +
                              "' on copy '" + copy + "'");
}

class Grower {
 public:
  Grower(const Scene& given, const ScaleSize& size) : given_(given), size_(size), scene_(given) {}

  Scene grow() {
    scene_.name += "_" + std::to_string(size_.users) + "x" + std::to_string(size_.objects);
    add_objects();
    add_users();
    scene_.couplers.clear();
    for (int o = 0; o < size_.objects; ++o)
      if (given_.architecture == core::Architecture::kCentral)
        join_server(scene_.objects[o].name);
      else
        join_copies(scene_.objects[o].name);
    return scene_;
  }

 private:
  void add_objects() {
    scene_.objects.clear();
    for (int o = 0; o < size_.objects; ++o) {
      core::ObjectParameters object = given_.objects[0];
      if (o > 0) object.name += std::to_string(o + 1);
      object.position.x += kApart * o;
      object.mass *= std::max(1, size_.users - 1);
      scene_.objects.push_back(object);
    }
  }

  void add_users() {
    scene_.users.clear();
    scene_.devices.clear();
    for (int u = 0; u < size_.users; ++u) {
      const int place = u % size_.objects;
      const int sharers = (size_.users - 1 - place) / size_.objects + 1;
      // The shipped hands are 24 mm apart in height, the outermost of many as well.
      const double height =
          sharers < 2 ? 0.0 : 0.012 - 0.024 * (u / size_.objects) / (sharers - 1.0);
      core::UserParameters user = given_.users[u == 0 ? 0 : 1];
      user.name = std::to_string(u + 1);
      for (core::FingerParameters& finger : user.fingers) {
        finger.position.x += kApart * place;
        finger.position.y = height;
        core::DeviceParameters device =
            given_.devices[core::index_of(given_.devices, finger.device)];
        device.name = user.name + finger.name;
        finger.device = device.name;
        scene_.devices.push_back(device);
      }
      scene_.users.push_back(user);
    }
  }

  void join_server(const std::string& object) {
    for (int u = 0; u < size_.users; ++u)
      add(coupler(given_, given_.users[u == 0 ? 0 : 1].name, ""), object, scene_.users[u].name, "");
  }

  void join_copies(const std::string& object) {
    const std::string one = given_.users[0].name, two = given_.users[1].name;
    for (const core::UserParameters& copy : scene_.users) {
      for (const core::UserParameters& user : scene_.users)
        add(coupler(given_, user.name == copy.name ? one : two, one), object, user.name, copy.name);
      add(coupler(given_, "", one), object, "", copy.name);
    }
  }

  void add(CouplerParameters like, const std::string& object, const std::string& user,
           const std::string& copy) {
    like.name = "k" + std::to_string(scene_.couplers.size());
    like.object = object;
    like.user = user;
    like.copy = copy;
    scene_.couplers.push_back(like);
  }

  const Scene& given_;
  ScaleSize size_;
  Scene scene_;
};

}  // namespace

core::Scene grown_scene(const core::Scene& given, const ScaleSize& size) {
  check(given, size);
  if (size.users == 2 && size.objects == 1) return given;
  return Grower(given, size).grow();
}

}  // namespace tandem::bench
