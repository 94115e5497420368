#include <earpoint/train/people_example.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include <earpoint/error.h>
#include <earpoint/people/description.h>
#include <earpoint/people/view.h>

namespace earpoint {
namespace {

using D = PeopleDescription;

// Less visible or smaller people need not be found.
constexpr double kLeastVisible = 0.3;
constexpr double kLeastHeight_px = 12.0;
constexpr double kLeastWidth_px = 4.0;
// Share of a person's box that a part of the picture must keep.
constexpr double kLeastKept = 0.3;
// Standard deviation of the bell around a middle, as a share of the box, and its minimum in cells.
constexpr double kBellPart = 0.12;
constexpr double kLeastBell_cells = 0.6;
constexpr float kLeastBoxWeight = 0.3F;

/// People within a part of the picture, in fractions of that part.
std::vector<LabelledPerson> people_within(const std::vector<LabelledPerson>& people,
                                          const Box& part) {
  std::vector<LabelledPerson> within;
  for (const LabelledPerson& person : people) {
    const auto x = [&](double value) { return (value - part.x_min) / (part.x_max - part.x_min); };
    const auto y = [&](double value) { return (value - part.y_min) / (part.y_max - part.y_min); };
    const Box whole{.x_min = x(person.box.x_min),
                    .y_min = y(person.box.y_min),
                    .x_max = x(person.box.x_max),
                    .y_max = y(person.box.y_max)};
    const Box seen{.x_min = std::clamp(whole.x_min, 0.0, 1.0),
                   .y_min = std::clamp(whole.y_min, 0.0, 1.0),
                   .x_max = std::clamp(whole.x_max, 0.0, 1.0),
                   .y_max = std::clamp(whole.y_max, 0.0, 1.0)};
    const double kept = (seen.x_max - seen.x_min) * (seen.y_max - seen.y_min) /
                        ((whole.x_max - whole.x_min) * (whole.y_max - whole.y_min));
    if (kept <= 0.0) continue;
    within.push_back({seen, kept < kLeastKept ? 0.0 : person.visible.value_or(1.0)});
  }
  return within;
}

/// The largest part of a picture with `aspect` times the proportions of a view, in fractions.
Box largest_part(const Image& picture, int width, int height, double aspect) {
  const double wanted = aspect * width / height;
  const double has = static_cast<double>(picture.width()) / picture.height();
  return {.x_min = 0.0,
          .y_min = 0.0,
          .x_max = std::min(1.0, wanted / has),
          .y_max = std::min(1.0, has / wanted)};
}

Box drawn_part(const Image& picture, int width, int height, RandomStream& random) {
  constexpr double kMostStretch = 0.2;  // as a logarithm
  constexpr double kZoomedOut = 0.15;   // of the examples
  const Box largest =
      largest_part(picture, width, height, std::exp(random.uniform(-kMostStretch, kMostStretch)));
  const double scale = random.uniform() < kZoomedOut ? random.uniform(1.0, 1.5)
                                                     : std::sqrt(random.uniform(0.2, 1.0));
  const double across = scale * largest.x_max;
  const double down = scale * largest.y_max;
  const double x = random.uniform() * (1.0 - across);
  const double y = random.uniform() * (1.0 - down);
  return {.x_min = x, .y_min = y, .x_max = x + across, .y_max = y + down};
}

void mirror(PeopleView& view) {
  ImagePlanes& planes = view.planes;
  for (auto row = planes.values.begin(); row != planes.values.end(); row += planes.width) {
    std::reverse(row, row + planes.width);
  }
  for (LabelledPerson& person : view.people) {
    const Box box = person.box;
    person.box.x_min = 1.0 - box.x_max;
    person.box.x_max = 1.0 - box.x_min;
  }
}

/// Changes the light and the camera's colours.
void recolour(ImagePlanes& planes, RandomStream& random) {
  const double gamma = std::exp(random.uniform(-0.5, 0.5));
  const double gain = std::exp(random.uniform(-0.35, 0.25));
  const float saturation =
      random.uniform() < 0.1 ? 0.0F : static_cast<float>(random.uniform(0.5, 1.4));
  // Powers from a table that is finer than a picture's steps.
  constexpr int kEntries = 1024;
  std::array<std::array<float, kEntries + 1>, 3> tables{};
  for (auto& table : tables) {
    const double tint = gain * std::exp(0.1 * random.normal());
    for (int i = 0; i <= kEntries; ++i) {
      table[static_cast<std::size_t>(i)] =
          static_cast<float>(tint * std::pow(static_cast<double>(i) / kEntries, gamma));
    }
  }
  const std::size_t pixels = planes.values.size() / 3;
  for (std::size_t i = 0; i < pixels; ++i) {
    std::array<float, 3> rgb{};
    for (std::size_t c = 0; c < 3; ++c) {
      const float value = std::clamp(planes.values[c * pixels + i] + D::kMiddleGrey, 0.0F, 1.0F);
      rgb[c] = tables[c][static_cast<std::size_t>(value * kEntries)];
    }
    const float grey = (rgb[0] + rgb[1] + rgb[2]) / 3.0F;
    for (std::size_t c = 0; c < 3; ++c) {
      const float value = grey + saturation * (rgb[c] - grey);
      planes.values[c * pixels + i] = std::clamp(value, 0.0F, 1.0F) - D::kMiddleGrey;
    }
  }
}

/// Mean over three pixels along each axis, except at the edges.
void blur(ImagePlanes& planes) {
  const auto mean_of_three = [&](std::ptrdiff_t step) {
    const std::vector<float> from = planes.values;
    for (std::ptrdiff_t i = step; i + step < std::ssize(from); ++i) {
      planes.values[i] = (from[i - step] + from[i] + from[i + step]) / 3.0F;
    }
  };
  mean_of_three(1);
  mean_of_three(planes.width);
}

/// Adds camera noise, uniform, with standard deviation `level`.
void add_noise(ImagePlanes& planes, double level, RandomStream& random) {
  const auto width = static_cast<float>(level * std::sqrt(12.0));
  constexpr float kStep = 1.0F / 65536.0F;
  for (std::size_t i = 0; i < planes.values.size(); i += 4) {
    std::uint64_t bits = random.next();  // enough for four
    for (std::size_t j = i; j < std::min(i + 4, planes.values.size()); ++j, bits >>= 16U) {
      planes.values[j] += width * (static_cast<float>(bits & 0xFFFFU) * kStep - 0.5F);
    }
  }
}

/// Fills the arrays of one example.
class TargetMaps {
 public:
  TargetMaps(int width_px, int height_px)
      : width_px_(width_px),
        height_px_(height_px),
        columns_(width_px / D::kCell),
        rows_(height_px / D::kCell),
        middles_(cells()),
        boxes_(4 * cells()),
        weights_(cells()),
        background_(cells(), 1.0F),
        truth_(5 * kMostTruths) {}

  void add(const LabelledPerson& person) {
    const Box box{.x_min = person.box.x_min * width_px_,
                  .y_min = person.box.y_min * height_px_,
                  .x_max = person.box.x_max * width_px_,
                  .y_max = person.box.y_max * height_px_};
    const double width = box.x_max - box.x_min;
    const double height = box.y_max - box.y_min;
    const bool counts = person.visible.value_or(1.0) >= kLeastVisible &&
                        height >= kLeastHeight_px && width >= kLeastWidth_px;
    if (people_ < kMostTruths) {
      const Box& b = person.box;
      const std::array row{b.x_min, b.y_min, b.x_max, b.y_max, counts ? 1.0 : 0.5};
      std::ranges::transform(row, truth_.begin() + static_cast<std::ptrdiff_t>(5 * people_++),
                             [](double value) { return static_cast<float>(value); });
    }
    if (counts) {
      add_bell(box);
    } else {
      leave_out(box);
    }
  }

  [[nodiscard]] std::map<std::string, std::vector<float>> take() && {
    return {{std::string(kMiddlesInput), std::move(middles_)},
            {std::string(kBoxesInput), std::move(boxes_)},
            {std::string(kBoxWeightsInput), std::move(weights_)},
            {std::string(kBackgroundInput), std::move(background_)},
            {std::string(kTruthInput), std::move(truth_)}};
  }

 private:
  [[nodiscard]] std::size_t cells() const { return static_cast<std::size_t>(columns_) * rows_; }

  void add_bell(const Box& box) {
    const double x = 0.5 * (box.x_min + box.x_max) / D::kCell;
    const double y = 0.5 * (box.y_min + box.y_max) / D::kCell;
    const int column = std::clamp(static_cast<int>(x), 0, columns_ - 1);
    const int row = std::clamp(static_cast<int>(y), 0, rows_ - 1);
    const auto spread = [](double size_px) {
      return std::max(kLeastBell_cells, kBellPart * size_px / D::kCell);
    };
    const double across = spread(box.x_max - box.x_min);
    const double down = spread(box.y_max - box.y_min);
    for (int j = 0; j < rows_; ++j) {
      for (int i = 0; i < columns_; ++i) {
        const double dx = (i - column) / across;
        const double dy = (j - row) / down;
        const auto bell = static_cast<float>(std::exp(-0.5 * (dx * dx + dy * dy)));
        const std::size_t cell = static_cast<std::size_t>(j) * columns_ + i;
        if (bell <= middles_[cell]) continue;
        middles_[cell] = bell;
        if (bell < kLeastBoxWeight) continue;
        weights_[cell] = bell;
        const std::array edges{box.x_min, box.y_min, box.x_max, box.y_max};
        for (std::size_t e = 0; e < 4; ++e) {
          boxes_[e * cells() + cell] = static_cast<float>(edges[e]);
        }
      }
    }
  }

  void leave_out(const Box& box) {
    for (int j = 0; j < rows_; ++j) {
      for (int i = 0; i < columns_; ++i) {
        const double x = (i + 0.5) * D::kCell;
        const double y = (j + 0.5) * D::kCell;
        if (x < box.x_min - D::kCell || x > box.x_max + D::kCell || y < box.y_min - D::kCell ||
            y > box.y_max + D::kCell) {
          continue;
        }
        background_[static_cast<std::size_t>(j) * columns_ + i] = 0.0F;
      }
    }
  }

  int width_px_;
  int height_px_;
  int columns_;
  int rows_;
  std::vector<float> middles_;
  std::vector<float> boxes_;
  std::vector<float> weights_;
  std::vector<float> background_;
  std::vector<float> truth_;
  std::size_t people_ = 0;
};

}  // namespace

PeopleView plain_people_view(const Image& picture, const PeoplePicture& labels, int width,
                             int height) {
  Box part = largest_part(picture, width, height, 1.0);
  const double x = 0.5 * (1.0 - part.x_max);
  const double y = 0.5 * (1.0 - part.y_max);
  part = {.x_min = x, .y_min = y, .x_max = 1.0 - x, .y_max = 1.0 - y};
  return {people_view_of_part(picture, part, width, height), people_within(labels.people, part)};
}

PeopleView varied_people_view(const Image& picture, const PeoplePicture& labels, int width,
                              int height, RandomStream& random) {
  const Box part = drawn_part(picture, width, height, random);
  PeopleView view{people_view_of_part(picture, part, width, height),
                  people_within(labels.people, part)};
  if (random.uniform() < 0.5) mirror(view);
  recolour(view.planes, random);
  if (random.uniform() < 0.25) blur(view.planes);
  if (random.uniform() < 0.3) add_noise(view.planes, random.uniform(0.0, 0.05), random);
  return view;
}

TrainingExample people_example(PeopleView view) {
  EARPOINT_CHECK(view.planes.width % D::kCoarsest == 0 && view.planes.height % D::kCoarsest == 0);
  TargetMaps maps(view.planes.width, view.planes.height);
  for (const LabelledPerson& person : view.people) maps.add(person);
  return {{}, {}, std::move(view.planes.values), std::move(maps).take()};
}

}  // namespace earpoint
