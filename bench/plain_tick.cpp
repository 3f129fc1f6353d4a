#include "bench/plain_tick.h"

#include <cmath>

namespace tandem::bench {

void plain_tick(const PlainScene& s, PlainState& z, const PlainFinger* fingers,
                const PlainBody& other) noexcept {
  const double T = s.T;
  const PlainBody b = z.body;
  const double c = std::cos(b.angle), sn = std::sin(b.angle);
  double fx = 0, fy = 0, tau = 0;

  for (int i = 0; i < 4; ++i) {
    PlainContact& k = z.finger[i];
    const double rx = fingers[i].x - b.x, ry = fingers[i].y - b.y;
    const double ux = fingers[i].vx - b.vx + b.omega * ry;
    const double uy = fingers[i].vy - b.vy - b.omega * rx;
    const double px = c * rx + sn * ry, py = -sn * rx + c * ry;
    const double qx = c * ux + sn * uy, qy = -sn * ux + c * uy;
    z.force_x[i] = z.force_y[i] = 0;
    const double dx = s.half_x - std::fabs(px), dy = s.half_y - std::fabs(py);
    if (dx <= 0 || dy <= 0) {
      k.state = 0;
      continue;
    }
    if (k.state == 0) {
      k.side = dx < dy ? (px > 0 ? 0 : 1) : (py > 0 ? 2 : 3);
      k.anchor = k.side < 2 ? py : px;
      k.state = 2;
    }
    double depth, vn, t, vt;
    switch (k.side) {
      case 0:
        depth = s.half_x - px, vn = qx, t = py, vt = qy;
        break;
      case 1:
        depth = s.half_x + px, vn = -qx, t = py, vt = qy;
        break;
      case 2:
        depth = s.half_y - py, vn = qy, t = px, vt = qx;
        break;
      default:
        depth = s.half_y + py, vn = -qy, t = px, vt = qx;
        break;
    }
    double fn = s.kn * depth - s.bn * vn;
    if (fn < 0) fn = 0;
    if (k.state == 3 && std::fabs(vt) <= s.v_tr) k.state = 2;
    double ft = -s.kt * (t - k.anchor) - s.bt * vt;
    if (k.state == 2 && std::fabs(ft) > s.mu_s * fn) k.state = 3;
    if (k.state == 3) {
      double stretch = t - k.anchor;
      const double limit = s.mu_k * fn;
      const double direction =
          std::fabs(vt) > s.v_tr ? (vt > 0 ? 1.0 : -1.0) : (stretch > 0 ? 1.0 : -1.0);
      double length = std::fabs(stretch);
      if (s.kt * length > limit) length = limit / s.kt;
      k.anchor = t - direction * length;
      ft = -direction * limit;
    }
    double lx, ly;
    switch (k.side) {
      case 0:
        lx = fn, ly = ft;
        break;
      case 1:
        lx = -fn, ly = ft;
        break;
      case 2:
        lx = ft, ly = fn;
        break;
      default:
        lx = ft, ly = -fn;
        break;
    }
    const double gx = c * lx - sn * ly, gy = sn * lx + c * ly;
    z.force_x[i] = gx;
    z.force_y[i] = gy;
    fx -= gx;
    fy -= gy;
    tau -= rx * gy - ry * gx;
  }

  for (int w = 0; w < 2; ++w) {
    const double nx = s.wall_nx[w], ny = s.wall_ny[w];
    const double fall = std::fabs(b.omega) * (s.half_x + s.half_y) - (b.vx * nx + b.vy * ny);
    const double soon = fall > 0 ? fall * T : 0.0;
    for (int i = 0; i < 4; ++i) {
      PlainContact& k = z.corner[w][i];
      const double lx = (i == 0 || i == 3) ? s.half_x : -s.half_x;
      const double ly = i < 2 ? s.half_y : -s.half_y;
      const double rx = c * lx - sn * ly, ry = sn * lx + c * ly;
      const double px = b.x + rx, py = b.y + ry;
      const double depth = -((px - s.wall_x[w]) * nx + (py - s.wall_y[w]) * ny);
      if (depth <= -soon) {
        k.state = 0;
        continue;
      }
      const double ux = b.vx - b.omega * ry, uy = b.vy + b.omega * rx;
      const double vn = ux * nx + uy * ny;
      const double end = depth - T * vn;
      if (depth <= 0 && end <= 0) {
        k.state = 0;
        continue;
      }
      double part = 1, mean = 0.5 * (depth + end);  // of the tick inside, and of the depth over it
      if (depth <= 0) {
        part = end / (end - depth);
        mean = 0.5 * part * end;
      } else if (end <= 0) {
        part = depth / (depth - end);
        mean = 0.5 * part * depth;
      }
      const double t = -ny * px + nx * py, vt = -ny * ux + nx * uy;
      if (k.state == 0) {
        k.anchor = t;
        k.state = 2;
      }
      double fn = s.wkn * mean - s.wbn * part * vn;
      if (fn < 0) fn = 0;
      if (k.state == 3 && std::fabs(vt) <= s.wv_tr) k.state = 2;
      double ft = -s.wkt * (t - k.anchor) - s.wbt * vt;
      if (k.state == 2 && std::fabs(ft) > s.wmu_s * fn) k.state = 3;
      if (k.state == 3) {
        const double stretch = t - k.anchor;
        const double limit = s.wmu_k * fn;
        const double direction =
            std::fabs(vt) > s.wv_tr ? (vt > 0 ? 1.0 : -1.0) : (stretch > 0 ? 1.0 : -1.0);
        double length = std::fabs(stretch);
        if (s.wkt * length > limit) length = limit / s.wkt;
        k.anchor = t - direction * length;
        ft = -direction * limit;
      }
      const double gx = nx * fn - ny * ft, gy = ny * fn + nx * ft;
      fx += gx;
      fy += gy;
      const double half_turn = 0.5 * T * b.omega;  // to the middle of the tick
      tau += (rx - half_turn * ry) * gy - (ry + half_turn * rx) * gx;
    }
  }

  fx += s.ko * (other.x - b.x) + s.bo * (other.vx - b.vx);
  fy += s.ko * (other.y - b.y) + s.bo * (other.vy - b.vy);
  tau += s.kr * (other.angle - b.angle) + s.br * (other.omega - b.omega);

  PlainBody& n = z.body;
  double vx = b.vx + T * fx / s.mass, vy = b.vy + T * fy / s.mass;
  const double speed = std::sqrt(vx * vx + vy * vy), loss = T * s.friction_force / s.mass;
  if (speed <= loss) {
    vx = vy = 0;
  } else {
    const double keep = 1 - loss / speed;
    vx *= keep;
    vy *= keep;
  }
  n.x = b.x + 0.5 * T * (b.vx + vx);
  n.y = b.y + 0.5 * T * (b.vy + vy);
  n.vx = vx;
  n.vy = vy;
  double omega = b.omega + T * tau / s.inertia;
  const double spin_loss = T * s.friction_torque / s.inertia;
  if (std::fabs(omega) <= spin_loss)
    omega = 0;
  else
    omega -= omega > 0 ? spin_loss : -spin_loss;
  n.angle = b.angle + 0.5 * T * (b.omega + omega);
  n.omega = omega;
}

}  // namespace tandem::bench
