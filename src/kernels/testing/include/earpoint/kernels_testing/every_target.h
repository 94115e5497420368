#pragma once

#include <cstdint>

#include <gtest/gtest.h>
#include <hwy/targets.h>

namespace earpoint::kernels {

/// Calls body() once per instruction set that was compiled, that this processor has and that is in
/// `among`.
template <typename Body>
void for_every_target(const Body& body, std::int64_t among = HWY_TARGETS) {
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    if ((target & among) == 0) continue;
    SCOPED_TRACE(hwy::TargetName(target));
    hwy::SetSupportedTargetsForTest(target);
    body();
  }
  hwy::SetSupportedTargetsForTest(0);
}

/// The same without the one that has no vectors, where that takes too long.
template <typename Body>
void for_every_simd_target(const Body& body) {
  for_every_target(body, HWY_TARGETS & ~(HWY_SCALAR | HWY_EMU128));
}

}  // namespace earpoint::kernels
