#include <filesystem>

#include <gtest/gtest.h>
#include <unistd.h>

#include <earpoint/dataset_testing/tiny_dataset.h>
#include <earpoint/error.h>
#include <earpoint/evaluate/evaluation_table.h>
#include <earpoint/evaluate/oracles.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

TEST(Oracles, EveryRungIsNearerThanTheOneBelow) {
  const fs::path folder = fs::path(testing::TempDir()) / ("oracles." + std::to_string(::getpid()));
  fs::remove_all(folder);
  write_tiny_dataset(folder, {.clips = 6});
  const auto set = soundspaces_evaluation_set(folder, "test", {}, {}, 10 << 20);
  std::vector<MethodEntry> methods{input_method()};
  for (MethodEntry& oracle : oracle_methods()) methods.push_back(std::move(oracle));
  SilentProgress silent;
  EvaluationOptions options;
  options.jobs = 2;
  const EvaluationTable table = make_table(evaluate(*set, methods, options, silent));
  ASSERT_EQ(table.rows.size(), 6U);
  for (std::size_t row = 1; row < table.rows.size(); ++row) {
    EXPECT_LT(table.rows[row][Metric::mag].mean->value,
              table.rows[row - 1][Metric::mag].mean->value)
        << table.rows[row].method;
  }
  // True energies leave no error of the level or the level difference, except for the constant in
  // LRE.
  for (const Metric metric : {Metric::level, Metric::lre}) {
    EXPECT_LT(table.rows[1][metric].mean->value, 1e-4);
  }
  // Two float convolutions, this one and that of the sampler.
  EXPECT_LT(table.rows[5][Metric::mag].mean->value, 1e-5);
  fs::remove_all(folder);
}

TEST(Oracles, WhatOnlyASimulatorKnowsIsRefusedOfRecordings) {
  PairSample sample;
  sample.source = Waveform(2, 16000, 16000);
  sample.target = sample.source;
  ASSERT_GT(oracle_methods().size(), 2U);
  for (const MethodEntry& oracle : oracle_methods()) {
    const auto render = [&] { (void)oracle.make()->render({sample, "session", nullptr}); };
    if (oracle.name != "oracle-gain" && oracle.name != "oracle-bands") {
      EXPECT_THROW(render(), InputError) << oracle.name;
    } else {
      EXPECT_NO_THROW(render()) << oracle.name;
    }
  }
}

}  // namespace
}  // namespace earpoint
