#pragma once

/// The planar tick written straight down in plain doubles: what a programmer writes who needs this
/// one scene, with 4 fingers, a box, 2 walls, ground friction and a coupler to another copy. It
/// shares no code with core/ and is what `tandem bench tick` compares with.
namespace tandem::bench {

struct PlainFinger {
  double x, y, vx, vy;
};

struct PlainContact {
  int state;  // 0 free, 2 pre-slide, 3 slide
  int side;   // 0 +x, 1 -x, 2 +y, 3 -y
  double anchor;
};

struct PlainBody {
  double x, y, angle, vx, vy, omega;
};

struct PlainScene {
  double T, mass, inertia, half_x, half_y;
  double kn, bn, kt, bt, mu_s, mu_k, v_tr;         // fingers
  double wkn, wbn, wkt, wbt, wmu_s, wmu_k, wv_tr;  // walls
  double wall_x[2], wall_y[2], wall_nx[2], wall_ny[2];
  double ko, bo, kr, br;  // to the other copy
  double friction_force, friction_torque;
};

struct PlainState {
  PlainBody body;
  PlainContact finger[4];
  PlainContact corner[2][4];
  double force_x[4], force_y[4];  // on the fingers
};

void plain_tick(const PlainScene& s, PlainState& z, const PlainFinger* fingers,
                const PlainBody& other) noexcept;

}  // namespace tandem::bench
