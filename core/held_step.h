#pragma once

namespace tandem::core {

/// Exact step over T of what moves under springs and dampers to things that stand still, seen from
/// where it was:  y' = v,  v' = -w y - d v + u,  y(0) = 0,  u held.
///   y(T) = y_v v0 + y_u u,   v(T) = v_v v0 + v_u u,   mean of y over T = mean_v v0 + mean_u u
struct HeldStep {
  double y_v = 0.0, y_u = 0.0;        ///< [s], [s^2]
  double v_v = 1.0, v_u = 0.0;        ///< [1], [s]
  double mean_v = 0.0, mean_u = 0.0;  ///< [s], [s^2]
};

/// The matrix exponential behind it, by Taylor series with scaling and squaring, arithmetic only;
/// done once, when a scene is loaded. `w` [1/s^2] and `d` [1/s] are stiffness and damping by mass.
[[nodiscard]] inline HeldStep held_step(double w, double d, double T) noexcept {
  // States z (integral of y), y, v and the held u. The rows of z, y, v; that of u is (0 0 0 1).
  int squarings = 0;
  double h = T;
  while ((w * h + d) * h > 0.0625) {
    h *= 0.5;
    ++squarings;
  }
  double m[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
  double term[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
  for (int k = 1; k <= 14; ++k) {
    for (auto& row : term) {  // term <- term * A h / k
      const double z = row[0], y = row[1], v = row[2];
      row[0] = 0.0;
      row[1] = (z - w * v) * h / k;
      row[2] = (y - d * v) * h / k;
      row[3] = v * h / k;
    }
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 4; ++c) m[r][c] += term[r][c];
  }
  for (int s = 0; s < squarings; ++s) {
    double square[3][4];
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 4; ++c)
        square[r][c] =
            m[r][0] * m[0][c] + m[r][1] * m[1][c] + m[r][2] * m[2][c] + (c == 3 ? m[r][3] : 0.0);
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 4; ++c) m[r][c] = square[r][c];
  }
  return {m[1][2], m[1][3], m[2][2], m[2][3], m[0][2] / T, m[0][3] / T};
}

}  // namespace tandem::core
