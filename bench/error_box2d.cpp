// Box2D 2.4 on the cases of `tandem bench error`. Lengths are ten times ours, where its fixed
// thresholds (0.005 of slop, bounces from 1 a second) are small, as its manual advises. Single
// precision: it has no other.
#include <box2d/box2d.h>
#include <cmath>
#include <memory>
#include <vector>

#include "bench/error_peer.h"
#include "bench/error_reference.h"

namespace tandem::bench {
namespace {

constexpr double kScale = 10.0;

struct Setting {
  const char* name;
  bool joints;  ///< masses, hands: its soft distance joint; else forces of our own every step
  int velocity, position;  ///< iterations
};

float scaled(double length) { return static_cast<float>(kScale * length); }

class Model {
 public:
  Model(const ErrorPoint& point, const Setting& setting, double T)
      : point_(point), setting_(setting), T_(T), world_({0.0F, 0.0F}) {
    world_.SetAllowSleeping(false);
    switch (point.which) {
      case Case::kMasses:
        add(kHandMass, 0.0), add(kObjectMass, kRest);
        bodies_[1]->SetLinearVelocity({scaled(kThrown), 0.0F});
        if (setting.joints) join(0, 1);
        break;
      case Case::kHands:
        add(kHandMass, 0.0), add(kObjectMass, kRest), add(kHandMass, 2.0 * kRest);
        if (setting.joints) join(0, 1), join(1, 2);
        break;
      case Case::kWall: {
        // Two circles: no skin between them. Rigid, with the rebound of the true bounce.
        add(kObjectMass, 0.0);
        bodies_[0]->SetLinearVelocity({scaled(kFlight), 0.0F});
        bodies_[0]->SetBullet(true);
        b2CircleShape circle;
        circle.m_radius = scaled(kRadius);
        b2FixtureDef fixture;
        fixture.shape = &circle;
        fixture.friction = 0.0F;
        fixture.restitution = static_cast<float>(rebound(point));
        bodies_[0]->CreateFixture(&fixture);
        set_mass(bodies_[0], kObjectMass);
        b2BodyDef ground;
        ground.position = {scaled(kGap + 2.0 * kRadius), 0.0F};
        world_.CreateBody(&ground)->CreateFixture(&fixture);
        break;
      }
      case Case::kStickSlip:
      case Case::kSlide: {
        add(point.which == Case::kSlide ? kObjectMass : kHandMass, 0.0);
        b2BodyDef ground;
        b2FrictionJointDef rub;
        rub.Initialize(world_.CreateBody(&ground), bodies_[0], {0.0F, 0.0F});
        rub.maxForce = scaled(kSlideFriction * kObjectMass * kGravity);
        friction_ = static_cast<b2FrictionJoint*>(world_.CreateJoint(&rub));
        if (point.which == Case::kSlide)
          bodies_[0]->SetLinearVelocity({scaled(kSlideSpeed[0]), scaled(kSlideSpeed[1])});
        break;
      }
      case Case::kSpin:
        break;
    }
  }

  void step() {
    if (point_.which == Case::kStickSlip) draw();
    if (point_.which == Case::kHands) push(0, kPushed[0]), push(2, kPushed[1]);
    if (!setting_.joints && (point_.which == Case::kMasses || point_.which == Case::kHands)) {
      couple(0, 1);
      if (point_.which == Case::kHands) couple(2, 1);
    }
    world_.Step(static_cast<float>(T_), setting_.velocity, setting_.position);
    ++steps_;
  }

  void sample(double* out) const {
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const b2Vec2 p = bodies_[i]->GetPosition(), v = bodies_[i]->GetLinearVelocity();
      const bool joined = point_.which == Case::kMasses || point_.which == Case::kHands;
      *out++ = (static_cast<double>(p.x) - (joined ? start_[i] : 0.0)) / kScale;
      if (point_.which == Case::kSlide) *out++ = p.y / kScale;
      *out++ = v.x / kScale;
      if (point_.which == Case::kSlide) *out++ = v.y / kScale;
    }
  }

 private:
  static constexpr double kRest = 0.1, kRadius = 0.05;  // [m]

  static void set_mass(b2Body* body, double mass) {
    b2MassData data;
    data.mass = static_cast<float>(mass);
    data.center = {0.0F, 0.0F};
    data.I = 1.0F;
    body->SetMassData(&data);
  }
  void add(double mass, double x) {
    b2BodyDef def;
    def.type = b2_dynamicBody;
    def.position = {scaled(x), 0.0F};
    def.fixedRotation = true;
    bodies_.push_back(world_.CreateBody(&def));
    start_.push_back(static_cast<double>(def.position.x));
    set_mass(bodies_.back(), mass);
  }
  void join(int a, int b) {
    b2DistanceJointDef def;
    def.Initialize(bodies_[a], bodies_[b], bodies_[a]->GetPosition(), bodies_[b]->GetPosition());
    def.minLength = 0.0F;
    def.maxLength = 1e6F;
    def.stiffness = static_cast<float>(point_.stiffness);
    def.damping = static_cast<float>(point_.damping);
    world_.CreateJoint(&def);
  }
  void push(int i, double force) { bodies_[i]->ApplyForceToCenter({scaled(force), 0.0F}, true); }
  void couple(int hand, int object) {
    const double stretch = bodies_[hand]->GetPosition().x - start_[hand] -
                           (bodies_[object]->GetPosition().x - start_[object]);
    const double speed =
        bodies_[hand]->GetLinearVelocity().x - bodies_[object]->GetLinearVelocity().x;
    const auto force = static_cast<float>(point_.stiffness * stretch + point_.damping * speed);
    bodies_[hand]->ApplyForceToCenter({-force, 0.0F}, true);
    bodies_[object]->ApplyForceToCenter({force, 0.0F}, true);
  }
  /// One coefficient is all it has: the larger while the mass stands.
  void draw() {
    const double x = bodies_[0]->GetPosition().x / kScale;
    const double v = bodies_[0]->GetLinearVelocity().x / kScale;
    push(0, kDrawSpring * (kDrawSpeed * T_ * steps_ - x));
    friction_->SetMaxForce(scaled((v > 1e-4 ? kSlips : kSticks) * kNormalForce));
  }

  ErrorPoint point_;
  Setting setting_;
  double T_;
  b2World world_;
  std::vector<b2Body*> bodies_;
  std::vector<double> start_;
  b2FrictionJoint* friction_ = nullptr;
  int steps_ = 0;
};

int run_peer(int argc, char** argv) {
  const ErrorPoint& point = asked_point(argc, argv);
  if (point.which == Case::kSpin) return 0;  // a plane has no such thing
  const bool joined = point.which == Case::kMasses || point.which == Case::kHands;
  const Setting settings[] = {
      {joined ? "soft joint, 8+3 iterations" : "8+3 iterations", true, 8, 3},
      {joined ? "soft joint, 1+1 iterations" : "1+1 iterations", true, 1, 1},
      {"own forces, 1+1 iterations", false, 1, 1}};
  for (const Setting& s : settings) {
    if (!s.joints && !joined) continue;
    run_all_rates(point, s.name, [&](double T) { return std::make_unique<Model>(point, s, T); });
  }
  return 0;
}

}  // namespace
}  // namespace tandem::bench

int main(int argc, char** argv) { return tandem::bench::run_peer(argc, argv); }
