#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <earpoint/core/random.h>
#include <earpoint/people/description.h>
#include <earpoint/people/engine.h>
#include <earpoint/people/weights.h>
#include <earpoint/train/initial_weights.h>
#include <earpoint/train/people_example.h>
#include <earpoint/train/people_learner.h>

namespace earpoint {
namespace {

constexpr int kWidth = 96;
constexpr int kHeight = 64;
constexpr PeopleDescription kSmall{96, 4};

/// Views of noise in which a bright upright rectangle is the person.
TrainingBatch bright_people(int views, std::uint64_t seed) {
  std::vector<TrainingExample> examples;
  for (int i = 0; i < views; ++i) {
    RandomStream random(seed, {static_cast<std::uint64_t>(i)});
    PeopleView view{{3, kHeight, kWidth, {}}, {}};
    const double x = random.uniform(0.05, 0.75);
    const double y = random.uniform(0.05, 0.35);
    const Box box{.x_min = x, .y_min = y, .x_max = x + 0.2, .y_max = y + 0.6};
    view.people = {{box, 1.0}};
    for (int c = 0; c < 3; ++c) {
      for (int row = 0; row < kHeight; ++row) {
        for (int column = 0; column < kWidth; ++column) {
          const double across = (column + 0.5) / kWidth;
          const double down = (row + 0.5) / kHeight;
          const bool is_person =
              across > box.x_min && across < box.x_max && down > box.y_min && down < box.y_max;
          view.planes.values.push_back(
              static_cast<float>(random.uniform(-0.2, 0.2) + (is_person ? 0.3 : -0.3)));
        }
      }
    }
    examples.push_back(people_example(std::move(view)));
  }
  return join(examples);
}

TEST(PeopleLearner, SeesAsTheEngineDoes) {
  PeopleLearner learner(initial_people_weights(kSmall, 3), kWidth, kHeight);
  const TrainingBatch batch = bright_people(2, 1);
  for (int step = 0; step < 3; ++step) {  // so that no weight has its initial value
    learner.compute_gradients(batch);
    learner.apply_gradients(1e-2);
  }
  const std::vector<float> maps = learner.maps(batch);
  float largest = 0.0F;
  for (const float value : maps) largest = std::max(largest, std::abs(value));
  PeopleNetwork engine(learner.weights());
  for (std::size_t view = 0; view < 2; ++view) {
    const std::size_t pixels = std::size_t{3} * kHeight * kWidth;
    const auto first = batch.pictures.begin() + static_cast<std::ptrdiff_t>(view * pixels);
    const ImagePlanes planes{
        3, kHeight, kWidth, {first, first + static_cast<std::ptrdiff_t>(pixels)}};
    const auto map = engine.run(planes);
    ASSERT_EQ(map.size(), maps.size() / 2);
    // Two implementations of twenty float32 layers that sum in different order.
    for (std::size_t i = 0; i < map.size(); ++i) {
      EXPECT_NEAR(map[i], maps[view * map.size() + i], 1e-4 * largest) << i;
    }
  }
}

TEST(PeopleLearner, GradientIsTheSlopeOfTheLoss) {
  const PeopleWeights weights = initial_people_weights(kSmall, 5);
  const TrainingBatch batch = bright_people(2, 2);
  PeopleLearner learner(weights, kWidth, kHeight);
  learner.compute_gradients(batch);
  const std::map<std::string, Tensor> gradients = learner.gradients();
  for (const char* name : {"output.weight", "head.0.0.weight", "lateral.3.weight"}) {
    const auto gradient = gradients.at(name).as<float>();
    const auto at = std::ranges::max_element(
        gradient, [](float a, float b) { return std::abs(a) < std::abs(b); });
    const auto loss_with = [&](float step) {
      PeopleWeights moved = weights;
      const auto values = moved.at(name).as<float>();
      std::vector<float> changed(values.begin(), values.end());
      changed[static_cast<std::size_t>(at - gradient.begin())] += step;
      moved.tensors[name] = make_tensor<float>(changed, moved.at(name).shape);
      return PeopleLearner(moved, kWidth, kHeight).compute_gradients(batch);
    };
    constexpr float kStep = 2e-3F;
    const double slope = (loss_with(kStep) - loss_with(-kStep)) / (2.0 * kStep);
    // Higher-order terms of a step that is large against float32's rounding, and that rounding: of
    // the loss, over the step.
    EXPECT_NEAR(slope, *at, 0.05 * std::abs(*at) + 1e-3) << name;
  }
}

TEST(PeopleLearner, LearnsToFindBrightPeople) {
  PeopleLearner learner(initial_people_weights(kSmall, 7), kWidth, kHeight);
  const TrainingBatch held_out = bright_people(16, 1000);
  for (std::uint64_t step = 0; step < 120; ++step) {
    learner.compute_gradients(bright_people(4, step));
    learner.apply_gradients(4e-3);
  }
  double error = 0.0;
  for (const double of_view : learner.errors(held_out)) error += of_view / 16;
  // Three of four are found. A network that finds nobody, as at first, has an error of 1, and one
  // that always answers the same box of almost 0.9: it overlaps one person in eight by half.
  EXPECT_LT(error, 0.25);
}

TEST(PeopleLearner, GoesOnFromItsCheckpointAsIfUnbroken) {
  PeopleLearner whole(initial_people_weights(kSmall, 9), kWidth, kHeight);
  const auto learn = [](PeopleLearner& learner, std::uint64_t step) {
    const double loss = learner.compute_gradients(bright_people(2, step));
    learner.apply_gradients(1e-3);
    return loss;
  };
  for (std::uint64_t step = 0; step < 2; ++step) learn(whole, step);
  PeopleLearner resumed = PeopleLearner::from_checkpoint(whole.checkpoint(), "x", kWidth, kHeight);
  EXPECT_EQ(resumed.steps(), 2);
  for (std::uint64_t step = 2; step < 4; ++step) {
    EXPECT_EQ(learn(resumed, step), learn(whole, step));
  }
}

}  // namespace
}  // namespace earpoint
