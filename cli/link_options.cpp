#include "cli/link_options.h"

#include "cli/options.h"

namespace tandem::cli {

void LinkOptions::add(CLI::App& command) {
  command.add_option("--link-delay-ms", delay_ms, "delay of every link, one way [ms]")
      ->check(between(0.0, 1000.0))
      ->excludes(command.get_option("--delay-packets"));
  command.add_option("--jitter-ms", jitter_ms, "jitter of every packet [ms]")
      ->check(between(0.0, 500.0));
  command
      .add_option("--jitter-kind", jitter_kind,
                  "normal (sd), uniform (half width), exponential (mean)")
      ->check(CLI::IsMember({"normal", "uniform", "exponential"}));
  command.add_option("--loss", loss, "share of packets lost, each by itself")
      ->check(between(0.0, 1.0));
  command
      .add_option("--burst-enter", burst_enter,
                  "Gilbert-Elliott: into the state that loses all, a packet")
      ->check(between(0.0, 1.0));
  command.add_option("--burst-leave", burst_leave, "and out of it")->check(between(0.0, 1.0));
  command.add_flag("--fifo", fifo, "jitter never reorders");
}

core::LinkModelParameters LinkOptions::model(double local_hz) const {
  core::LinkModelParameters link;
  link.delay_ticks = delay_ms * 1e-3 * local_hz;
  link.jitter_ticks = jitter_ms * 1e-3 * local_hz;
  if (jitter_ms > 0.0)
    link.jitter = jitter_kind == "uniform"       ? core::JitterKind::kUniform
                  : jitter_kind == "exponential" ? core::JitterKind::kExponential
                                                 : core::JitterKind::kNormal;
  link.loss = loss;
  link.burst_enter = burst_enter;
  link.burst_leave = burst_leave;
  link.first_in_first_out = fifo;
  return link;
}

}  // namespace tandem::cli
