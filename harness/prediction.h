#pragma once

#include <functional>
#include <limits>
#include <string>

#include "core/network_model.h"
#include "core/scene.h"

namespace tandem::harness {

/// What the analysis says of one session, beside which the measured stands.
struct Prediction {
  bool judged = false;  ///< false: the analysis does not apply, `note` says why
  /// False: the network has no growth per packet (jitter, loss), and a steady one took its place
  /// whose samples have the same mean age.
  bool exact = true;
  std::string note;  ///< assumptions, or why not
  bool stable = false;
  double growth_per_packet = std::numeric_limits<double>::quiet_NaN();  ///< spectral radius
  double drag = std::numeric_limits<double>::quiet_NaN();      ///< of drag_user() alone [N s/m]
  double coupling = std::numeric_limits<double>::quiet_NaN();  ///< k_o or k_2 as it is [N/m]
  /// Upper end of the stable interval of that coupling around what the scene has or, where that is
  /// not stable, of the next one below [N/m]. 0: none down to a 64th; infinite: stable up to 64
  /// times.
  double largest_coupling = std::numeric_limits<double>::quiet_NaN();
  double stiffness = std::numeric_limits<double>::quiet_NaN();  ///< rendered, others held [N/m]
  /// The side changes within 10 % of the coupling or of the delays (at least a tick): what is
  /// measured may fall on either.
  bool near_boundary = false;
};

struct PredictOptions {
  bool largest_coupling = true;  ///< costs some 40 judgements
  /// Delays that are no whole ticks (means of measured ones, which differ by a tick from packet to
  /// packet) lie between two networks: the coupling is taken between theirs, and a session on
  /// different sides of stability in the two is near the boundary. False: the nearest whole ticks.
  bool between_ticks = false;
};

/// Predicts a session over a network with these delays [ticks] and packet phases. Only delays and
/// phases are read: give measured ones for a real run. Jitter and loss are the caller's to put into
/// the delays (steady_network), who then sets `exact`. Any scene; what is assumed to make it linear
/// is in `note`.
[[nodiscard]] Prediction predict(const core::Scene& scene, const core::NetworkModel& network,
                                 const PredictOptions& options = {});

/// Prediction::largest_coupling alone, between ticks, to 0.1 %; cheap near the answer: `scene` has
/// the coupling to start from. Not a number where the analysis does not apply [N/m].
[[nodiscard]] double predicted_coupling(const core::Scene& scene,
                                        const core::NetworkModel& network);

/// Drag of drag_user() alone over a network of these delays; delays that are no whole ticks (within
/// a twentieth) lie between their neighbours. Not a number where the analysis does not apply [N
/// s/m].
[[nodiscard]] double predicted_drag(const core::Scene& scene, const core::NetworkModel& network);

/// Whether the map of drag_user() alone is stable: only then is there a drag to measure.
[[nodiscard]] bool stable_alone(const core::Scene& scene, const core::NetworkModel& network);

/// Largest stable value as Prediction::largest_coupling defines it, of any judge: from `now` up
/// while stable or down while not, by `ratio`, then bisected to `precision` (a ratio, 1.01 is 1 %).
[[nodiscard]] double largest_stable(double now, double ratio, double precision,
                                    const std::function<bool(double)>& stable);

/// Force over displacement that drag_user() feels at rest while the others' hands are held, of the
/// scene `touched` by that user; not a number where the analysis does not apply [N/m].
[[nodiscard]] double predicted_stiffness(const core::Scene& touched_scene,
                                         const core::NetworkModel& network);

/// Smallest one-way delay [s], the same both ways, in whole ticks, with which the scene is not
/// stable; infinite if it is up to `longest`; 0: never stable.
[[nodiscard]] double predicted_delay_boundary(const core::Scene& scene, double longest);

/// A network without jitter and loss whose held samples have the same mean age as those of
/// `network`, link by link, from its own model run over `packets` packets.
[[nodiscard]] core::NetworkModel steady_network(const core::Scene& scene,
                                                const core::NetworkModel& network,
                                                int packets = 4096);
/// Mean age of the samples in use over a steady network, over all links of the scene [s].
[[nodiscard]] double mean_age(const core::Scene& scene, const core::NetworkModel& steady);
/// Whether the two would be the same.
[[nodiscard]] bool is_steady(const core::NetworkModel& network);

/// The couplers that a largest stable coupling is asked of, and their common name: central the
/// remote hands' (k_2), distributed those between copies (k_o).
[[nodiscard]] std::string coupling_name(const core::Scene& scene);
[[nodiscard]] double coupling_of(const core::Scene& scene);
/// All of them scaled so that the first is `stiffness`.
[[nodiscard]] core::Scene with_coupling(core::Scene scene, double stiffness);

}  // namespace tandem::harness
