#include <gtest/gtest.h>

#include <earpoint/core/progress.h>
#include <earpoint/record/sync.h>
#include <earpoint/record_testing/test_session.h>

namespace earpoint {
namespace {

SyncErrors errors_of(const TestSessionOptions& options) {
  const TestSession made = make_test_session(options);
  SilentProgress silent;
  const SyncResult result = synchronize(made.sounds, {}, silent);
  for (const std::string& note : result.notes) ADD_FAILURE() << note;
  EXPECT_EQ(result.devices.size(), made.sounds.devices.size());
  return compare_clocks(result, made.truth, options.duration_s);
}

TEST(Sync, FindsClocksOfPeopleWhoWalkToHalfAMillisecond) {
  const SyncErrors errors = errors_of({.cameras = 4, .people = 2, .duration_s = 40.0});
  // What is asked for at 10 dB SNR.
  EXPECT_LE(errors.offset_error_ms_p95, 0.5);
  // One part in a million is asked for over 5 minutes; the same error of times makes 7.5 times as
  // much over 40 s.
  EXPECT_LE(errors.drift_error_ppm_p95, 7.5);
}

TEST(Sync, FindsDriftToAPartInAMillionOverFiveMinutes) {
  // Four cameras: eight ears, three coordinates.
  const SyncErrors errors = errors_of({.cameras = 4, .people = 3, .duration_s = 300.0, .seed = 11});
  // Both are what is asked for at 10 dB SNR.
  EXPECT_LE(errors.offset_error_ms_p95, 0.5);
  EXPECT_LE(errors.drift_error_ppm_p95, 1.0);
}

}  // namespace
}  // namespace earpoint
