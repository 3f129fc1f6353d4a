// Bullet 3.24 in double precision on the cases of `tandem bench error`.
#include <btBulletDynamicsCommon.h>
#include <cmath>
#include <memory>
#include <vector>

#include "bench/error_peer.h"

namespace tandem::bench {
namespace {

struct Setting {
  const char* name;
  bool joints;  ///< masses, hands: its 6-dof spring joint; else forces of our own every step
  int iterations;
  int gyroscopic;  ///< flag of the body
};

class Model {
 public:
  Model(const ErrorPoint& point, const Setting& setting, double T)
      : point_(point),
        setting_(setting),
        T_(T),
        dispatcher_(&configuration_),
        world_(&dispatcher_, &broadphase_, &solver_, &configuration_) {
    world_.setGravity({0, 0, 0});
    world_.getSolverInfo().m_numIterations = setting.iterations;
    world_.getSolverInfo().m_splitImpulse = 0;
    switch (point.which) {
      case Case::kMasses:
        add(kHandMass, true), add(kObjectMass, true);
        bodies_[1]->setLinearVelocity({kThrown, 0, 0});
        if (setting.joints) join(0, 1);
        break;
      case Case::kHands:
        add(kHandMass, true), add(kObjectMass, true), add(kHandMass, true);
        if (setting.joints) join(0, 1), join(2, 1);
        break;
      case Case::kWall: {
        shapes_.push_back(
            std::make_unique<btStaticPlaneShape>(btVector3(-1, 0, 0), -(kGap + kRadius)));
        add_ground(1.0);
        add(kObjectMass, false);
        bodies_[0]->setLinearVelocity({kFlight, 0, 0});
        bodies_[0]->setContactStiffnessAndDamping(point.stiffness, point.damping);
        ground_->setContactStiffnessAndDamping(1e18, 0.0);
        break;
      }
      case Case::kStickSlip:
      case Case::kSlide: {
        const bool slides = point.which == Case::kSlide;
        world_.setGravity({0, 0, slides ? -kGravity : -kNormalForce / kHandMass});
        shapes_.push_back(std::make_unique<btStaticPlaneShape>(btVector3(0, 0, 1), 0));
        add_ground(1.0);
        box_ = true;
        add(slides ? kObjectMass : kHandMass, false);
        bodies_[0]->setFriction(slides ? kSlideFriction : kSticks);
        if (slides) bodies_[0]->setLinearVelocity({kSlideSpeed[0], kSlideSpeed[1], 0});
        break;
      }
      case Case::kSpin:
        add(kObjectMass, true);
        bodies_[0]->setMassProps(kObjectMass, {kMoments[0], kMoments[1], kMoments[2]});
        bodies_[0]->updateInertiaTensor();
        bodies_[0]->setAngularFactor(1.0);
        bodies_[0]->setFlags(setting.gyroscopic);
        bodies_[0]->setAngularVelocity({kSpin[0], kSpin[1], kSpin[2]});
        break;
    }
  }

  ~Model() {
    for (auto& joint : joints_) world_.removeConstraint(joint.get());
    for (auto& body : bodies_) world_.removeRigidBody(body.get());
    if (ground_) world_.removeRigidBody(ground_.get());
  }
  Model(const Model&) = delete;
  Model& operator=(const Model&) = delete;

  void step() {
    if (point_.which == Case::kStickSlip) draw();
    if (point_.which == Case::kHands) push(0, kPushed[0]), push(2, kPushed[1]);
    if (!setting_.joints && (point_.which == Case::kMasses || point_.which == Case::kHands)) {
      couple(0, 1);
      if (point_.which == Case::kHands) couple(2, 1);
    }
    world_.stepSimulation(T_, 0);
    ++steps_;
  }

  void sample(double* out) const {
    for (const auto& body : bodies_) {
      const btVector3 &p = body->getCenterOfMassPosition(), &v = body->getLinearVelocity();
      if (point_.which == Case::kSpin) {
        const btQuaternion q = body->getOrientation();
        const btVector3& w = body->getAngularVelocity();
        for (const double x : {q.w(), q.x(), q.y(), q.z(), w.x(), w.y(), w.z()}) *out++ = x;
        return;
      }
      *out++ = p.x();
      if (point_.which == Case::kSlide) *out++ = p.y();
      *out++ = v.x();
      if (point_.which == Case::kSlide) *out++ = v.y();
    }
  }

 private:
  static constexpr double kRadius = 0.05;  // [m]

  void add_ground(double friction) {
    const btRigidBody::btRigidBodyConstructionInfo info(0, nullptr, shapes_.back().get());
    ground_ = std::make_unique<btRigidBody>(info);
    ground_->setFriction(friction);
    world_.addRigidBody(ground_.get());
  }
  void add(double mass, bool alone) {
    if (box_)
      shapes_.push_back(std::make_unique<btBoxShape>(btVector3(kRadius, kRadius, kRadius)));
    else
      shapes_.push_back(std::make_unique<btSphereShape>(kRadius));
    btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, shapes_.back().get(),
                                                  btVector3(1, 1, 1));
    info.m_startWorldTransform.setIdentity();
    if (box_) info.m_startWorldTransform.setOrigin({0, 0, kRadius});
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    bodies_.back()->setActivationState(DISABLE_DEACTIVATION);
    bodies_.back()->setDamping(0, 0);
    bodies_.back()->setAngularFactor(0.0);
    if (alone)
      world_.addRigidBody(bodies_.back().get(), 0, 0);
    else
      world_.addRigidBody(bodies_.back().get());
  }
  void join(int a, int b) {
    btTransform frame;
    frame.setIdentity();
    auto joint =
        std::make_unique<btGeneric6DofSpring2Constraint>(*bodies_[a], *bodies_[b], frame, frame);
    for (int axis = 0; axis < 6; ++axis) joint->setLimit(axis, 1, -1);  // free
    joint->enableSpring(0, true);
    joint->setStiffness(0, point_.stiffness, false);
    joint->setDamping(0, point_.damping, false);
    joint->setEquilibriumPoint(0, 0.0);
    world_.addConstraint(joint.get(), true);
    joints_.push_back(std::move(joint));
  }
  void push(int i, double force) { bodies_[i]->applyCentralForce({force, 0, 0}); }
  void couple(int hand, int object) {
    const btVector3 p =
        bodies_[hand]->getCenterOfMassPosition() - bodies_[object]->getCenterOfMassPosition();
    const btVector3 v = bodies_[hand]->getLinearVelocity() - bodies_[object]->getLinearVelocity();
    const double force = point_.stiffness * p.x() + point_.damping * v.x();
    push(hand, -force);
    push(object, force);
  }
  /// One coefficient is all it has: the larger while the mass stands.
  void draw() {
    push(0, kDrawSpring * (kDrawSpeed * T_ * steps_ - bodies_[0]->getCenterOfMassPosition().x()));
    bodies_[0]->setFriction(bodies_[0]->getLinearVelocity().x() > 1e-4 ? kSlips : kSticks);
  }

  ErrorPoint point_;
  Setting setting_;
  double T_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  std::unique_ptr<btRigidBody> ground_;
  std::vector<std::unique_ptr<btGeneric6DofSpring2Constraint>> joints_;
  bool box_ = false;
  int steps_ = 0;
};

int run_peer(int argc, char** argv) {
  const ErrorPoint& point = asked_point(argc, argv);
  std::vector<Setting> settings;
  switch (point.which) {
    case Case::kMasses:
    case Case::kHands:
      settings = {{"spring joint, 10 iterations", true, 10, 0},
                  {"spring joint, 50 iterations", true, 50, 0},
                  {"own forces", false, 1, 0}};
      break;
    case Case::kSpin:
      settings = {
          {"gyroscopic, implicit in the body", true, 1, BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY},
          {"gyroscopic, explicit", true, 1, BT_ENABLE_GYROSCOPIC_FORCE_EXPLICIT}};
      break;
    default:
      settings = {{"10 iterations", true, 10, 0}, {"50 iterations", true, 50, 0}};
  }
  for (const Setting& s : settings)
    run_all_rates(point, s.name, [&](double T) { return std::make_unique<Model>(point, s, T); });
  return 0;
}

}  // namespace
}  // namespace tandem::bench

int main(int argc, char** argv) { return tandem::bench::run_peer(argc, argv); }
