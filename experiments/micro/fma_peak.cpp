#include "fma_peak.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <thread>

#include <hwy/targets.h>

// The order of these matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fma_peak.cpp"
#include <hwy/foreach_target.h>

#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace earpoint::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// @return  operations done; `sink` makes them count
double multiply_add(std::int64_t rounds, float* sink) {
  constexpr int kSums = 12;
  const hn::ScalableTag<float> d;
  hn::Vec<decltype(d)> sums[kSums];
  HWY_UNROLL(12)
  for (int i = 0; i < kSums; ++i) sums[i] = hn::Set(d, static_cast<float>(i));
  const auto factor = hn::Set(d, 0.999F);
  auto term = hn::Set(d, 0.001F);
  for (std::int64_t round = 0; round < rounds; ++round) {
    HWY_UNROLL(12)
    for (int i = 0; i < kSums; ++i) sums[i] = hn::MulAdd(sums[i], factor, term);
  }
  HWY_UNROLL(12)
  for (int i = 1; i < kSums; ++i) sums[0] = hn::Add(sums[0], sums[i]);
  *sink = hn::GetLane(sums[0]);
  return 2.0 * kSums * static_cast<double>(hn::Lanes(d)) * static_cast<double>(rounds);
}

}  // namespace earpoint::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace earpoint {
namespace {

HWY_EXPORT(multiply_add);

double gflops_of_all(int threads) {
  constexpr std::int64_t kRounds = 2'000'000;
  std::atomic<int> ready{0};
  std::vector<double> gflops(threads);
  const auto work = [&](int thread) {
    ready.fetch_add(1);
    while (ready.load() < threads) {
    }
    float sink = 0.0F;
    const auto start = std::chrono::steady_clock::now();
    const double operations = HWY_DYNAMIC_DISPATCH(multiply_add)(kRounds, &sink);
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    gflops[thread] = sink != 0.0F ? operations / taken.count() / 1e9 : 0.0;
  };
  std::vector<std::thread> others;
  for (int thread = 1; thread < threads; ++thread) others.emplace_back(work, thread);
  work(0);
  for (std::thread& other : others) other.join();
  double sum = 0.0;
  for (const double of_thread : gflops) sum += of_thread;
  return sum;
}

}  // namespace

std::vector<FmaPeak> measure_fma_peaks(int threads) {
  constexpr int kTries = 3;
  std::vector<FmaPeak> peaks;
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    FmaPeak peak{hwy::TargetName(target), 0.0};
    for (int i = 0; i < kTries; ++i) peak.gflops = std::max(peak.gflops, gflops_of_all(threads));
    peaks.push_back(peak);
  }
  hwy::SetSupportedTargetsForTest(0);
  return peaks;
}

}  // namespace earpoint

#endif  // HWY_ONCE
