#pragma once

/// Marks a function whose loops are worth compiling for several vector widths; the processor
/// chooses at start-up. Results do not differ: each lane computes on its own, without fused
/// operations.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define EARPOINT_VECTOR_CLONES \
  __attribute__((target_clones("avx512f", "avx2", "default"), optimize("O3")))
/// The same for loops over complex numbers whose parts lie side by side. Where there are fused
/// operations GCC 12 takes them for such differences and sums, whatever -ffp-contract says.
#define EARPOINT_VECTOR_CLONES_OF_PAIRS \
  __attribute__((target_clones("avx2", "default"), optimize("O3")))
#else
// Where the loader's choice of functions is not to be had, or gets in a sanitizer's way.
#define EARPOINT_VECTOR_CLONES
#define EARPOINT_VECTOR_CLONES_OF_PAIRS
#endif

/// Before a loop whose passes do not depend on each other, though it writes where it cannot be seen
/// that it does not read.
#if defined(__GNUC__) && !defined(__clang__)
#define EARPOINT_INDEPENDENT_PASSES _Pragma("GCC ivdep")
#else
#define EARPOINT_INDEPENDENT_PASSES
#endif
