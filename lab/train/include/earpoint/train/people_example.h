#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include <earpoint/core/random.h>
#include <earpoint/core/resize.h>
#include <earpoint/dataset/people_pictures.h>
#include <earpoint/image.h>
#include <earpoint/train/training_batch.h>

namespace earpoint {

/// Names among TrainingExample::inputs. Cells are those of PeopleDescription::kCell pixels.
/// How near each cell is to the middle of a person: 1 at the cell that holds it, falling around it
/// like a bell as wide as a part of the person. [height][width]
inline constexpr std::string_view kMiddlesInput = "middles";
/// The box of the person nearest to each cell, x_min, y_min, x_max, y_max in pixels of the view.
/// [4][height][width]
inline constexpr std::string_view kBoxesInput = "boxes";
/// How much each cell's box counts. [height][width]
inline constexpr std::string_view kBoxWeightsInput = "box_weights";
/// 0 where a cell says nothing about the background: within people that one need not find, as too
/// little is seen of them. [height][width]
inline constexpr std::string_view kBackgroundInput = "background";
/// Everybody: x_min, y_min, x_max, y_max in fractions of the view, and 1 for a person, 0.5 for one
/// that need not be found, 0 for none. [kMostTruths][5]
inline constexpr std::string_view kTruthInput = "truth";
inline constexpr std::size_t kMostTruths = 8;

/// A picture as the network is trained on it.
struct PeopleView {
  ImagePlanes planes;  ///< as people_view() has them
  /// In fractions of the view.
  std::vector<LabelledPerson> people;
};

/// The largest part of a picture that has a view's proportions, from its middle, unchanged.
[[nodiscard]] PeopleView plain_people_view(const Image& picture, const PeoplePicture& labels,
                                           int width, int height);

/// A part of a picture as another camera might have taken it: any part and size, stretched a
/// little, mirrored, in other light and colours, blurred, noisy.
[[nodiscard]] PeopleView varied_people_view(const Image& picture, const PeoplePicture& labels,
                                            int width, int height, RandomStream& random);

[[nodiscard]] TrainingExample people_example(PeopleView view);

}  // namespace earpoint
