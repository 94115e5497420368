#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/core/file.h>
#include <earpoint/network_testing/refusal.h>
#include <earpoint/train/train_config.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

std::string refusal_of(const std::string& network, const std::string& training) {
  return refusal([&] {
    const TrainConfig config =
        train_config_from_json(R"({"format": "earpoint-train-1", "network": )" + network +
                                   R"(, "training": )" + training + "}",
                               "c.json");
    static_cast<void>(vigas_config_from_json(config.network, "c.json: 'network'", true));
  });
}

TEST(TrainConfig, MisspeltKeysAndBadValuesAreNamed) {
  const std::string vigas = R"({"kind": "vigas"})";
  EXPECT_EQ(refusal_of(vigas, R"({"steps": 5})"), "accepted");
  EXPECT_EQ(refusal_of(vigas, R"({"steps": 5, "bathc": 4})"),
            "c.json: 'training': unknown key 'bathc'");
  EXPECT_EQ(refusal_of(vigas, R"({"steps": 5, "batch": 0})"),
            "c.json: 'training': 'batch': expected 1 to 65536, found 0");
  EXPECT_EQ(refusal_of(vigas, R"({})"), "c.json: 'training': the field 'steps' is missing");
  EXPECT_EQ(refusal_of(vigas, R"({"steps": 5, "schedule": "cosin"})"),
            "c.json: 'training': 'schedule': expected one of \"constant\", \"cosine\", found "
            "\"cosin\"");
  EXPECT_EQ(refusal_of(R"({"kind": "vigas", "chanels": 3})", R"({"steps": 5})"),
            "c.json: 'network': unknown key 'chanels'");
  EXPECT_EQ(refusal_of(R"({"channels": 3})", R"({"steps": 5})"),
            "c.json: 'network': expected an object with a 'kind'");
  EXPECT_NE(refusal([] {
              static_cast<void>(pair_options_from_json(R"({"separate": false})", "x"));
            }).find("'ambient_db'"),
            std::string::npos);
  EXPECT_NE(refusal([] {
              static_cast<void>(pair_options_from_json(R"({"ambient": "mmse"})", "x"));
            }).find("'ambient'"),
            std::string::npos);
  EXPECT_NE(refusal([] {
              static_cast<void>(pair_options_from_json(
                  R"({"second_voices": 0.1, "target": "near_microphone"})", "x"));
            }).find("'second_voices'"),
            std::string::npos);
}

TEST(TrainConfig, AblationsLeaveInputsOut) {
  const auto inputs_of = [](const std::string& json) {
    std::string names;
    for (const auto& input : vigas_config_from_json(json, "x", true).description.inputs) {
      names += input.name + " ";
    }
    return names;
  };
  EXPECT_EQ(inputs_of("{}"), "visual_feat tgt_pose tgt_rotation bboxes ");
  EXPECT_EQ(inputs_of(R"({"picture": null})"), "tgt_pose tgt_rotation bboxes ");
  EXPECT_EQ(inputs_of(R"({"box": false})"), "visual_feat tgt_pose tgt_rotation ");
  EXPECT_EQ(inputs_of(R"({"picture": null, "box": false})"), "tgt_pose tgt_rotation ");
}

TEST(TrainConfig, ExtendsOverridesKeyByKeyAndNullCounts) {
  const fs::path folder = fs::path(testing::TempDir()) / "train_config_test";
  fs::create_directories(folder / "below");
  write_file(folder / "base.json", std::string_view(R"({"format": "earpoint-train-1",
    "network": {"kind": "vigas", "channels": 16, "picture": {"width_px": 64}},
    "training": {"steps": 7, "batch": 3}})"));
  write_file(folder / "below/child.json", std::string_view(R"({"extends": "../base.json",
    "network": {"picture": null}, "training": {"steps": 9}})"));
  const TrainConfig config = read_train_config(folder / "below/child.json");
  EXPECT_EQ(config.training.steps, 9);
  EXPECT_EQ(config.training.batch, 3);
  const ViGasConfig network = vigas_config_from_json(config.network, "x", true);
  EXPECT_EQ(network.description.channels, 16);
  EXPECT_FALSE(network.description.image_encoder.has_value());
  // The merged text gives the same without its base.
  EXPECT_EQ(train_config_from_json(config.text, "x").text, config.text);

  write_file(folder / "loop.json", std::string_view(R"({"extends": "loop.json"})"));
  EXPECT_NE(refusal([&] {
              static_cast<void>(read_train_config(folder / "loop.json"));
            }).find("chain is too long"),
            std::string::npos);
  fs::remove_all(folder);
}

TEST(TrainConfig, SettingsOverrideTheFileByTypeAndAreKept) {
  const fs::path file = fs::path(testing::TempDir()) / "train_config_settings.json";
  write_file(file, std::string_view(R"({"format": "earpoint-train-1",
    "network": {"kind": "vigas", "channels": 16, "picture": {"width_px": 64}},
    "training": {"steps": 7, "batch": 3}})"));
  const auto read = [&](const std::vector<ConfigSetting>& settings) {
    return read_train_config(file, settings);
  };
  const TrainConfig config = read({{"training.steps", "9"},
                                   {"network.picture.height_px", "32"},
                                   {"network.box", "false"},
                                   {"data.align", "none"},
                                   {"data.ambient_db", "-40"},
                                   {"training.steps", "11"}});
  EXPECT_EQ(config.training.steps, 11);
  EXPECT_EQ(config.training.batch, 3);
  const ViGasConfig network = vigas_config_from_json(config.network, "x", true);
  ASSERT_TRUE(network.description.image_encoder.has_value());
  EXPECT_EQ(network.description.image_encoder->width_px, 64);
  EXPECT_EQ(network.description.image_encoder->height_px, 32);
  EXPECT_FALSE(network.description.has_input("bboxes"));
  const PairOptions pairs = pair_options_from_json(config.data, "x");
  EXPECT_EQ(pairs.alignment, Alignment::none);
  EXPECT_EQ(pairs.ambient_db, -40.0);
  EXPECT_EQ(train_config_from_json(config.text, "x").text, config.text);

  const auto refused = [&](const std::string& key, const std::string& value) {
    return refusal([&] { static_cast<void>(read({{key, value}})); });
  };
  EXPECT_NE(refused("training.stpes", "9").find("'training': unknown key 'stpes'"),
            std::string::npos);
  EXPECT_NE(refused("trainings.steps", "9").find("unknown key 'trainings'"), std::string::npos);
  EXPECT_NE(refused("training.steps", "many").find("steps"), std::string::npos);
  EXPECT_NE(refused("training.steps.first", "9").find("'first' is not in an object"),
            std::string::npos);
  EXPECT_NE(refused("training..steps", "9").find("expected names"), std::string::npos);
  EXPECT_NE(refused("network.picture", R"({"width_px": 1, "width_px": 2})").find("width_px"),
            std::string::npos);
  fs::remove(file);
}

TEST(TrainConfig, ShippedConfigurationsAreReadable) {
  int count = 0;
  for (const auto& entry :
       fs::recursive_directory_iterator(fs::path(EARPOINT_SOURCE_DIR) / "configs")) {
    if (entry.path().extension() != ".json") continue;
    const TrainConfig config = read_train_config(entry.path());
    if (config.kind != "vigas") continue;
    ++count;
    const PairOptions pairs = pair_options_from_json(config.data, entry.path().string());
    static_cast<void>(
        vigas_config_from_json(config.network, entry.path().string(), pairs.separate));
  }
  EXPECT_GE(count, 4);
}

TEST(LearningRate, WarmsUpAndFallsAlongACosine) {
  TrainingPlan plan;
  plan.steps = 100;
  plan.learning_rate = 0.01;
  plan.warmup_steps = 10;
  EXPECT_DOUBLE_EQ(learning_rate_at(plan, 0, 0.0), 0.001);
  EXPECT_DOUBLE_EQ(learning_rate_at(plan, 50, 0.5), 0.01);
  plan.schedule = Schedule::cosine;
  EXPECT_NEAR(learning_rate_at(plan, 50, 0.5), 0.005, 1e-12);
  EXPECT_NEAR(learning_rate_at(plan, 99, 1.0), 0.0, 1e-12);
}

}  // namespace
}  // namespace earpoint
