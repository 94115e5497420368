#include <filesystem>

#include <gtest/gtest.h>
#include <unistd.h>

#include <earpoint/core/file.h>
#include <earpoint/dataset_testing/tiny_dataset.h>
#include <earpoint/error.h>
#include <earpoint/evaluate/evaluation_table.h>
#include <earpoint/evaluate/transfer_function.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

class TransferFunctionTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / ("transfer." + std::to_string(::getpid()));
    fs::remove_all(folder_);
    write_tiny_dataset(folder_, {.clips = 4});
  }
  void TearDown() override { fs::remove_all(folder_); }

  /// Mean Mag of tf over that of input.
  [[nodiscard]] double ratio(TransferIndex index) const {
    const auto set = soundspaces_evaluation_set(folder_, "test", {}, {}, 10 << 20);
    SilentProgress silent;
    EvaluationOptions options;
    options.jobs = 2;
    const std::vector<MethodEntry> methods{
        input_method(), transfer_function_method(folder_, DatasetLayout::soundspaces, index)};
    return make_table(evaluate(*set, methods, options, silent)).rows[1][Metric::mag].ratio->value;
  }

  /// Replaces the training split by the test split with other voices.
  void train_where_it_is_tested() const {
    fs::remove_all(folder_ / "train");
    fs::copy(folder_ / "test", folder_ / "train", fs::copy_options::recursive);
    std::string metadata = read_text_file(folder_ / "train/room/cleaned_metadata_v3.json");
    for (std::size_t at = metadata.find("test/"); at != std::string::npos;
         at = metadata.find("test/", at)) {
      metadata.replace(at, 5, "train/");
    }
    write_file(folder_ / "train/room/cleaned_metadata_v3.json", metadata);
  }

  fs::path folder_;
};

TEST_F(TransferFunctionTest, WhereItWasTrainedTheFilterCarriesOver) {
  // In another room the nearest of a few pairs is of no use; at the same positions the filter is
  // right for another voice too. The tiny rooms reverberate little, so that a filter can invert the
  // source's response.
  const double elsewhere = ratio(TransferIndex::locations);
  train_where_it_is_tested();
  EXPECT_LT(ratio(TransferIndex::locations), 0.35);
  EXPECT_LT(ratio(TransferIndex::relative_pose), 0.35);
  EXPECT_GT(elsewhere, 0.7);
}

TEST_F(TransferFunctionTest, IndexFollowsWhetherTheScenesAreKnown) {
  EXPECT_EQ(transfer_index_for(folder_, DatasetLayout::soundspaces, {"room"}),
            TransferIndex::locations);
  EXPECT_EQ(transfer_index_for(folder_, DatasetLayout::soundspaces, {"room", "hall"}),
            TransferIndex::relative_pose);
}

TEST_F(TransferFunctionTest, UnknownSceneCannotBeLookedUpByLocation) {
  fs::rename(folder_ / "train/room", folder_ / "train/hall");
  EXPECT_THROW((void)ratio(TransferIndex::locations), InputError);
}

TEST_F(TransferFunctionTest, DataWithoutTrainingSplitIsRefused) {
  fs::remove_all(folder_ / "train");
  EXPECT_THROW(
      (void)transfer_function_method(folder_, DatasetLayout::soundspaces, TransferIndex::locations),
      InputError);
  EXPECT_THROW((void)transfer_index_for(folder_, DatasetLayout::soundspaces, {"room"}), InputError);
}

}  // namespace
}  // namespace earpoint
