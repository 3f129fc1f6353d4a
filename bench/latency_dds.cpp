// A peer of `tandem bench latency`: Cyclone DDS, best effort, newest sample only, a reader that
// blocks in a wait set. Two processes, so that nothing takes its way inside one.
#include <dds/dds.h>

#include "bench/latency_peer.h"
#include "latency_state.h"

namespace {

// Loopback only, no multicast.
constexpr const char* kConfiguration =
    "<General><Interfaces><NetworkInterface name=\"lo\"/></Interfaces>"
    "<AllowMulticast>false</AllowMulticast></General>"
    "<Discovery><ParticipantIndex>auto</ParticipantIndex>"
    "<Peers><Peer Address=\"127.0.0.1\"/></Peers></Discovery>";

[[noreturn]] void give_up(const char* why) {
  std::fprintf(stderr, "bench_latency_dds: %s\n", why);
  std::_Exit(1);
}

struct Side {
  dds_entity_t participant = 0, topic = 0;
  dds_qos_t* qos = nullptr;
};

Side open_side() {
  constexpr dds_domainid_t kDomain = 77;
  if (dds_create_domain(kDomain, kConfiguration) < 0) give_up("no domain on the loopback");
  Side side;
  side.participant = dds_create_participant(kDomain, nullptr, nullptr);
  side.topic =
      dds_create_topic(side.participant, &tandem_bench_State_desc, "state", nullptr, nullptr);
  side.qos = dds_create_qos();
  dds_qset_reliability(side.qos, DDS_RELIABILITY_BEST_EFFORT, 0);
  dds_qset_history(side.qos, DDS_HISTORY_KEEP_LAST, 1);
  if (side.topic < 0) give_up("no topic");
  return side;
}

/// Until somebody is at the other end.
void wait_for(dds_entity_t entity, std::uint32_t what) {
  dds_set_status_mask(entity, what);
  for (int i = 0; i < 1000; ++i) {
    std::uint32_t status = 0;
    if (dds_get_status_changes(entity, &status) == 0 && (status & what) != 0) return;
    usleep(10'000);
  }
  give_up("nobody at the other end within 10 s");
}

}  // namespace

int main(int words, char** word) {
  using namespace tandem::bench;
  return run_peer(
      words, word,
      [](const PeerRun&, PeerReport& report) {
        const Side side = open_side();
        const dds_entity_t reader =
            dds_create_reader(side.participant, side.topic, side.qos, nullptr);
        report.ready(0);
        const dds_entity_t set = dds_create_waitset(side.participant);
        const dds_entity_t condition = dds_create_readcondition(reader, DDS_ANY_STATE);
        dds_waitset_attach(set, condition, 0);
        for (;;) {
          if (dds_waitset_wait(set, nullptr, 0, DDS_SECS(10)) < 0) return;
          void* sample[1] = {nullptr};
          dds_sample_info_t info[1];
          while (dds_take(reader, sample, info, 1, 1) > 0) {
            const auto* state = static_cast<tandem_bench_State*>(sample[0]);
            const bool more = !info[0].valid_data || report.take(state->bytes._buffer);
            dds_return_loan(reader, sample, 1);
            if (!more) return;
          }
        }
      },
      [](const PeerRun&, int) {
        const Side side = open_side();
        const dds_entity_t writer =
            dds_create_writer(side.participant, side.topic, side.qos, nullptr);
        wait_for(writer, DDS_PUBLICATION_MATCHED_STATUS);
        return [=](const char* message, std::size_t bytes) {
          tandem_bench_State state{};
          state.bytes._maximum = state.bytes._length = static_cast<std::uint32_t>(bytes);
          state.bytes._buffer = reinterpret_cast<std::uint8_t*>(const_cast<char*>(message));
          dds_write(writer, &state);
        };
      });
}
