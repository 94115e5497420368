#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include <earpoint/image.h>
#include <earpoint/pose.h>
#include <earpoint/waveform.h>

namespace earpoint {

/// A person in a picture of a figure.
struct FigureBox {
  Box box;
  bool speaks = false;
};

/// A sound whose ears are drawn beside each other, or as one where it has one channel.
struct FigureSound {
  std::string label;
  Waveform sound;
};

/// One column of a row: what is seen at a viewpoint, and below it what is heard there.
struct FigureView {
  std::string title{};
  std::vector<std::string> caption{};        ///< lines below the picture
  Image picture{};                           ///< empty: a sketch from above, if there is a pose
  std::vector<FigureBox> boxes{};            ///< in the picture
  std::optional<Pose> source_from_target{};  ///< for the sketch
  std::optional<Vector3> speaker_m{};        ///< for the sketch; source view's frame
  std::vector<FigureSound> sounds{};         ///< one below the other
  /// Its waveforms have a scale of their own; those of all other columns of the row share one.
  bool has_own_scale = false;
};

/// One clip: the source, its targets, and what else there is to show.
struct FigureRow {
  std::string title;  ///< may be empty
  std::vector<FigureView> views;
};

/// Draws clips as the qualitative figure of the paper does: a row per clip, the source at the left,
/// targets beside it; left ear (blue) and right ear (orange) of every sound beside each other,
/// extremes pale and root mean square solid, with their levels in dB re full scale. A line below
/// tells so.
/// @param rows  at least one, none empty
/// @return an SVG document that carries its pictures (JPEG)
/// Source: Chen et al., Novel-View Acoustic Synthesis (CVPR 2023), the figure of qualitative
/// examples.
[[nodiscard]] std::string view_figure_svg(std::span<const FigureRow> rows);

/// A pose in words, the place and then the turn: {"1.5 m ahead, 0.2 m right", "turned 45° right"}.
[[nodiscard]] std::vector<std::string> words_of(const Pose& source_from_target);

}  // namespace earpoint
