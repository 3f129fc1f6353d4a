// What every law must keep: trivially copyable, and a copied session goes on to the same bits.
#include <cstring>
#include <type_traits>

#include <gtest/gtest.h>

#include "analysis/state_vector.h"
#include "analysis/with_loop.h"
#include "scene/load_scene.h"

namespace tandem {
namespace {

template <typename World>
constexpr bool kTrivial = std::is_trivially_copyable_v<distributed::ReplicaLaw<World>>&&
    std::is_trivially_copyable_v<central::ServerLaw<World>>&& std::is_trivially_copyable_v<
        central::ClientLaw<World>>&& std::is_trivially_copyable_v<core::SiteState<World>>&&
        std::is_trivially_copyable_v<core::ServerReply<World>>;
static_assert(kTrivial<core::AxisWorld> && kTrivial<core::PlaneWorld> &&
              kTrivial<core::SpaceWorld>);
static_assert(std::is_trivially_copyable_v<core::SimulatedHand<core::Vec2>>);

TEST(LawContract, ACopiedSessionRunsOnToTheSameBits) {
  for (const char* name : {"axis_distributed", "box_distributed", "box_central", "space_box"}) {
    core::LinkModelParameters link;
    link.delay_ticks = 5;
    link.jitter = core::JitterKind::kExponential;
    link.jitter_ticks = 6;
    link.loss = 0.1;
    core::NetworkModel network;
    network.set_all(link);
    analysis::with_loop(scene::load_scene(name), network, [&]<typename Loop>(Loop& loop) {
      for (int i = 0; i < 300; ++i) loop.advance_packet_period();
      Loop copy = loop;
      for (int i = 0; i < 300; ++i) {
        loop.advance_packet_period();
        copy.advance_packet_period();
      }
      const auto a = analysis::states_of(loop);
      const auto b = analysis::states_of(copy);
      EXPECT_EQ(a.size(), b.size()) << name;
      for (std::size_t i = 0; i < a.size() && i < b.size(); ++i)
        EXPECT_EQ(std::memcmp(a[i].value, b[i].value, sizeof(double)), 0) << name << " " << i;
      return 0;
    });
  }
}

// What a site sends and a peer unpacks is the same state, in every space.
TEST(LawContract, PackedStatesComeBackUnchanged) {
  const auto distributed = [&](auto world, const char* name) {
    using World = decltype(world);
    distributed::DistributedLoop<World> loop(scene::load_scene(name));
    for (int i = 0; i < 400; ++i) loop.advance_packet_period();
    core::SiteState<World> sent = loop.law(0).site(), got{};
    core::StatePacket packet;
    const auto counts = loop.law(0).counts(0);
    core::pack(sent, counts, packet);
    core::unpack(packet, counts, got);
    std::vector<analysis::StateEntry> a, b;
    core::visit_site(sent, counts, analysis::StateCollector(a));
    core::visit_site(got, counts, analysis::StateCollector(b));
    ASSERT_EQ(static_cast<int>(a.size()), packet.value_count) << name;
    for (std::size_t i = 0; i < a.size(); ++i) EXPECT_EQ(*a[i].value, *b[i].value) << name << i;
    EXPECT_EQ(sent.contact_bits, got.contact_bits);
    EXPECT_EQ(sent.energy_out, got.energy_out);
  };
  distributed(core::AxisWorld{}, "axis_distributed");
  distributed(core::PlaneWorld{}, "box_distributed");
  distributed(core::SpaceWorld{}, "space_box");
}

}  // namespace
}  // namespace tandem
