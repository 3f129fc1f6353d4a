#include "arch_central/server_law.h"

#include "core/axis_world.h"
#include "core/plane_world.h"
#include "core/space_world.h"

namespace tandem::central {

template class ServerLaw<core::AxisWorld>;
template class ServerLaw<core::PlaneWorld>;
template class ServerLaw<core::SpaceWorld>;

}  // namespace tandem::central
