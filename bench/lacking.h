#pragma once

/// The law of one replica compiled several times: as shipped, and each time without one of the
/// features that the scene does not declare (bench/lacking.py takes it out of the sources). Every
/// copy lives in a namespace of its own and is reached through this table; it names no type of
/// Tandem, as each copy has its own.
namespace bench_lacking {

struct Law {
  /// `ticks` ticks of the same session in the middle of the grasp, between two calls of `mark`.
  /// Space 0: axis, 1: plane.
  void (*run)(int space, int ticks, void (*mark)());
  /// Processor time of a tick in that session after the grasp [ns].
  double (*tick_ns)(int space, int ticks);
  /// Hash of the bits of the object's motion over `ticks` ticks.
  unsigned long long (*bits)(int space, int ticks);
};

}  // namespace bench_lacking
