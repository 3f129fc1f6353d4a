#include "arch_distributed/replica_law.h"

#include "core/axis_world.h"
#include "core/plane_world.h"
#include "core/space_world.h"

namespace tandem::distributed {

template class ReplicaLaw<core::AxisWorld>;
template class ReplicaLaw<core::PlaneWorld>;
template class ReplicaLaw<core::SpaceWorld>;

}  // namespace tandem::distributed
