// One copy of the law, in the namespace that -Dtandem=... says and from the sources that the
// include folders say (bench/CMakeLists.txt).
#include <array>
#include <cstring>
#include <ctime>
#include <vector>

#include "arch_distributed/replica_law.cpp"  // all in one: compiled with the same sources
#include "bench/lacking.h"

namespace tandem {
namespace {

using core::Scene;

constexpr int kTicksPerPacket = 8;

/// Two users on one box, and nothing else declared: no wall, device, delay, silence, compensation,
/// friction, pulses, extrapolation.
Scene scene_of(int space) {
  Scene scene;
  scene.space = space == 0 ? core::Space::kAxis : core::Space::kPlane;
  scene.contact.attached = space == 0;
  core::ObjectParameters box;
  box.name = "box";
  box.shape = space == 0 ? core::Shape::kPoint : core::Shape::kBox;
  box.size = {0.1, 0.1, 0.0};
  box.mass = 0.7;
  scene.objects.push_back(box);
  for (const char* name : {"1", "2"}) {
    core::UserParameters user;
    user.name = name;
    user.mass = 0.07;
    user.fingers.resize(space == 0 ? 1 : 2);
    for (auto& finger : user.fingers) finger.position = {-0.051, 0.0, 0.0};
    if (space == 1) user.fingers[1].position.x = 0.051;
    scene.users.push_back(user);
    core::CouplerParameters hand;
    hand.object = "box", hand.user = name, hand.copy = "1";
    hand.gain = {800.0, 3.0};
    scene.couplers.push_back(hand);
  }
  core::CouplerParameters copies;
  copies.object = "box", copies.copy = "1";
  copies.gain = {400.0, 8.0}, copies.rotation = {10.0, 0.1};
  scene.couplers.push_back(copies);
  return scene;
}

/// Hands that close within 64 ticks and then swing with a period of 256, the same for every copy.
template <typename World>
struct Session {
  using Law = distributed::ReplicaLaw<World>;
  using Vector = typename World::Vector;

  explicit Session(int space) : scene(scene_of(space)), law(scene, 0) {
    for (int k = 0; k < kHand; ++k) {
      const int turn = k % 256;
      const double swing = 1e-4 * (turn < 128 ? turn - 64 : 192 - turn);  // a triangle
      for (int f = 0; f < static_cast<int>(scene.users[0].fingers.size()); ++f) {
        const double closed = k < 64 ? k / 64.0 : 1.0;
        const double side = f == 0 ? -1.0 : 1.0;
        hand[k][f].p = core::from_vec3<Vector>({side * (0.051 - 0.004 * closed) + swing, 0.01, 0});
        hand[k][f].v = core::from_vec3<Vector>({turn < 128 ? 0.1024 : -0.1024, 0.0, 0.0});
      }
      if (k % kTicksPerPacket == 0) {
        packets[k / kTicksPerPacket].fingers = hand[k];
        packets[k / kTicksPerPacket].objects[0] = World::initial_body(scene.objects[0]);
      }
    }
  }
  void tick() noexcept {
    const int k = slot < kHand ? slot : 256 + slot % 256;
    typename Law::Inputs inputs;
    if (k % kTicksPerPacket == 0) inputs.fresh[1] = &packets[k / kTicksPerPacket];
    inputs.age[1] = (k % kTicksPerPacket) * scene.tick();
    (void)law.observe(hand[k]);
    (void)law.tick(slot, inputs);
    ++slot;
  }

  static constexpr int kHand = 512;
  Scene scene;
  Law law;
  int slot = 0;
  std::array<core::HandSample<Vector>, kHand> hand{};
  std::array<core::SiteState<World>, kHand / kTicksPerPacket> packets{};
};

template <typename Use>
void with_session(int space, Use&& use) {
  if (space == 0) {
    static const Session<core::AxisWorld> start(0);
    Session<core::AxisWorld> session = start;
    use(session);
  } else {
    static const Session<core::PlaneWorld> start(1);
    Session<core::PlaneWorld> session = start;
    use(session);
  }
}

void run(int space, int ticks, void (*mark)()) {
  with_session(space, [&](auto& session) {
    for (int k = 0; k < 304; ++k) session.tick();
    mark();
    for (int k = 0; k < ticks; ++k) session.tick();
    mark();
  });
}

double core_ns() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e9 * static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec);
}

double tick_ns(int space, int ticks) {
  double took = 0.0;
  with_session(space, [&](auto& session) {
    for (int k = 0; k < 512; ++k) session.tick();
    const double before = core_ns();
    for (int k = 0; k < ticks; ++k) session.tick();
    took = (core_ns() - before) / ticks;
  });
  return took;
}

unsigned long long bits(int space, int ticks) {
  unsigned long long hash = 0xcbf29ce484222325u;
  with_session(space, [&](auto& session) {
    for (int k = 0; k < ticks; ++k) {
      session.tick();
      double x = 0.0;
      if constexpr (requires { session.law.object(0).p.x; })
        x = session.law.object(0).p.x;
      else
        x = session.law.object(0).p;
      unsigned long long word = 0;
      std::memcpy(&word, &x, sizeof word);
      hash = (hash ^ word) * 0x100000001b3u;
    }
  });
  return hash;
}

}  // namespace

extern const bench_lacking::Law kLaw;
const bench_lacking::Law kLaw{run, tick_ns, bits};

}  // namespace tandem
