// ODE 0.16 in double precision on the cases of `tandem bench error`.
#include <cmath>
#include <memory>
#include <ode/ode.h>
#include <vector>

#include "bench/error_peer.h"

namespace tandem::bench {
namespace {

enum class How { kJointsWorld, kJointsQuick, kForces };

struct Setting {
  const char* name;
  How how;
};

class Model {
 public:
  Model(const ErrorPoint& point, const Setting& setting, double T)
      : point_(point), setting_(setting), T_(T), world_(dWorldCreate()) {
    dWorldSetContactMaxCorrectingVel(world_, dInfinity);
    switch (point.which) {
      case Case::kMasses:
        add(kHandMass, 0.0), add(kObjectMass, kRest);
        dBodySetLinearVel(bodies_[1], kThrown, 0, 0);
        if (joints()) join(0, 1);
        break;
      case Case::kHands:
        add(kHandMass, 0.0), add(kObjectMass, kRest), add(kHandMass, 2.0 * kRest);
        if (joints()) join(0, 1), join(1, 2);
        break;
      case Case::kWall:
        add(kObjectMass, 0.0);
        dBodySetLinearVel(bodies_[0], kFlight, 0, 0);
        ground_ = dCreatePlane(nullptr, -1, 0, 0, -(kGap + kRadius));
        shape_ = dCreateSphere(nullptr, kRadius);
        dGeomSetBody(shape_, bodies_[0]);
        contacts_ = dJointGroupCreate(0);
        break;
      case Case::kStickSlip:
      case Case::kSlide: {
        const bool slides = point.which == Case::kSlide;
        add(slides ? kObjectMass : kHandMass, 0.0);
        dBodySetPosition(bodies_[0], 0, 0, kRadius);
        dWorldSetGravity(world_, 0, 0, slides ? -kGravity : -kNormalForce / kHandMass);
        ground_ = dCreatePlane(nullptr, 0, 0, 1, 0);
        shape_ = dCreateBox(nullptr, 2 * kRadius, 2 * kRadius, 2 * kRadius);
        dGeomSetBody(shape_, bodies_[0]);
        contacts_ = dJointGroupCreate(0);
        if (slides) dBodySetLinearVel(bodies_[0], kSlideSpeed[0], kSlideSpeed[1], 0);
        break;
      }
      case Case::kSpin: {
        add(kObjectMass, 0.0);
        dMass mass;
        dMassSetParameters(&mass, kObjectMass, 0, 0, 0, kMoments[0], kMoments[1], kMoments[2], 0, 0,
                           0);
        dBodySetMass(bodies_[0], &mass);
        dBodySetFiniteRotationMode(bodies_[0], 1);
        dBodySetGyroscopicMode(bodies_[0], 1);
        dBodySetAngularVel(bodies_[0], kSpin[0], kSpin[1], kSpin[2]);
        break;
      }
    }
  }
  ~Model() {
    if (contacts_ != nullptr) dJointGroupDestroy(contacts_);
    if (shape_ != nullptr) dGeomDestroy(shape_);
    if (ground_ != nullptr) dGeomDestroy(ground_);
    dWorldDestroy(world_);
  }
  Model(const Model&) = delete;
  Model& operator=(const Model&) = delete;

  void step() {
    if (point_.which == Case::kStickSlip) draw();
    if (point_.which == Case::kHands) push(0, kPushed[0]), push(2, kPushed[1]);
    if (!joints() && (point_.which == Case::kMasses || point_.which == Case::kHands)) {
      couple(0, 1);
      if (point_.which == Case::kHands) couple(2, 1);
    }
    if (contacts_ != nullptr) touch();
    if (setting_.how == How::kJointsQuick)
      dWorldQuickStep(world_, T_);
    else
      dWorldStep(world_, T_);
    if (contacts_ != nullptr) dJointGroupEmpty(contacts_);
    ++steps_;
  }

  void sample(double* out) const {
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const dReal *p = dBodyGetPosition(bodies_[i]), *v = dBodyGetLinearVel(bodies_[i]);
      if (point_.which == Case::kSpin) {
        for (int j = 0; j < 4; ++j) *out++ = dBodyGetQuaternion(bodies_[i])[j];
        for (int j = 0; j < 3; ++j) *out++ = dBodyGetAngularVel(bodies_[i])[j];
        return;
      }
      *out++ = p[0] - start_[i];
      if (point_.which == Case::kSlide) *out++ = p[1];
      *out++ = v[0];
      if (point_.which == Case::kSlide) *out++ = v[1];
    }
  }

 private:
  static constexpr double kRest = 0.1, kRadius = 0.05;  // [m]

  [[nodiscard]] bool joints() const { return setting_.how != How::kForces; }

  void add(double mass, double x) {
    const dBodyID body = dBodyCreate(world_);
    dMass m;
    // Moments so large that nothing turns; the spinning body sets its own.
    dMassSetParameters(&m, mass, 0, 0, 0, 1e6, 1e6, 1e6, 0, 0, 0);
    dBodySetMass(body, &m);
    dBodySetPosition(body, x, 0, 0);
    dBodySetAutoDisableFlag(body, 0);
    bodies_.push_back(body);
    start_.push_back(x);
  }
  /// A double ball joint keeps one distance; its error reduction and constraint force mixing are
  /// those of a spring and damper, as ODE's manual says.
  void join(int a, int b) {
    const dJointID joint = dJointCreateDBall(world_, nullptr);
    dJointAttach(joint, bodies_[a], bodies_[b]);
    dJointSetDBallAnchor1(joint, start_[a], 0, 0);
    dJointSetDBallAnchor2(joint, start_[b], 0, 0);
    const double k = point_.stiffness, damping = point_.damping;
    dJointSetDBallParam(joint, dParamERP, T_ * k / (T_ * k + damping));
    dJointSetDBallParam(joint, dParamCFM, 1.0 / (T_ * k + damping));
  }
  void push(int i, double force) { dBodyAddForce(bodies_[i], force, 0, 0); }
  void couple(int hand, int object) {
    const double stretch = dBodyGetPosition(bodies_[hand])[0] - start_[hand] -
                           (dBodyGetPosition(bodies_[object])[0] - start_[object]);
    const double speed =
        dBodyGetLinearVel(bodies_[hand])[0] - dBodyGetLinearVel(bodies_[object])[0];
    const double force = point_.stiffness * stretch + point_.damping * speed;
    push(hand, -force);
    push(object, force);
  }
  /// One coefficient is all it has: the larger while the mass stands.
  void draw() {
    push(0, kDrawSpring * (kDrawSpeed * T_ * steps_ - dBodyGetPosition(bodies_[0])[0]));
    friction_ = dBodyGetLinearVel(bodies_[0])[0] > 1e-4 ? kSlips : kSticks;
  }
  void touch() {
    dContact contact[4] = {};
    const int count = dCollide(shape_, ground_, 4, &contact[0].geom, sizeof(dContact));
    for (int i = 0; i < count; ++i) {
      dSurfaceParameters& s = contact[i].surface;
      if (point_.which == Case::kWall) {
        s.mode = dContactSoftERP | dContactSoftCFM;
        s.mu = 0;
        const double k = point_.stiffness, b = point_.damping;
        s.soft_erp = T_ * k / (T_ * k + b);
        s.soft_cfm = 1.0 / (T_ * k + b);
      } else {
        // Its friction is a pyramid; turned along the motion it is exact there.
        s.mode = dContactApprox1 | dContactFDir1;
        s.mu = friction_;
        const dReal* v = dBodyGetLinearVel(bodies_[0]);
        const double speed = std::hypot(v[0], v[1]);
        contact[i].fdir1[0] = speed > 1e-9 ? v[0] / speed : 1.0;
        contact[i].fdir1[1] = speed > 1e-9 ? v[1] / speed : 0.0;
      }
      dJointAttach(dJointCreateContact(world_, contacts_, &contact[i]), bodies_[0], nullptr);
    }
  }

  ErrorPoint point_;
  Setting setting_;
  double T_;
  dWorldID world_;
  std::vector<dBodyID> bodies_;
  std::vector<double> start_;
  dGeomID ground_ = nullptr, shape_ = nullptr;
  dJointGroupID contacts_ = nullptr;
  double friction_ = kSlideFriction;
  int steps_ = 0;
};

int run_peer(int argc, char** argv) {
  const ErrorPoint& point = asked_point(argc, argv);
  dInitODE2(0);
  dAllocateODEDataForThread(dAllocateMaskAll);
  const bool joined = point.which == Case::kMasses || point.which == Case::kHands;
  std::vector<Setting> settings{
      {joined ? "soft joint, world step" : "world step", How::kJointsWorld},
      {joined ? "soft joint, quick step" : "quick step", How::kJointsQuick}};
  if (joined) settings.push_back({"own forces, world step", How::kForces});
  for (const Setting& s : settings)
    run_all_rates(point, s.name, [&](double T) { return std::make_unique<Model>(point, s, T); });
  dCloseODE();
  return 0;
}

}  // namespace
}  // namespace tandem::bench

int main(int argc, char** argv) { return tandem::bench::run_peer(argc, argv); }
