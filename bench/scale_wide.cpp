// One row of `tandem bench scale`, measured by laws with other capacities than the shipped ones.
//   bench_scale_64x4 SCENE USERS OBJECTS ROUNDS SECONDS PRIORITY
// prints it as JSON.
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "bench/scale_json.h"
#include "scene/load_scene.h"

int main(int count, char** words) {
  if (count != 7) {
    std::fprintf(stderr,
                 "usage: %s SCENE USERS OBJECTS ROUNDS SECONDS PRIORITY\n"
                 "`tandem bench scale` runs it\n",
                 words[0]);
    return 2;
  }
  try {
    using namespace tandem;
    const bench::ScaleSize size{std::atoi(words[2]), std::atoi(words[3])};
    const bench::ScaleWork work{std::atoi(words[4]), std::atof(words[5]), std::atoi(words[6])};
    const core::Scene scene = scene::load_scene(words[1]);
    std::printf("%s\n", bench::to_json(bench::measure_scale(scene, size, work)).dump().c_str());
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
