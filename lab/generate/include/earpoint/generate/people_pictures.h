#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include <earpoint/scene/furniture.h>
#include <earpoint/scene/people.h>

namespace earpoint {

/// Which pictures of people to draw.
struct PeoplePictureOptions {
  std::filesystem::path out;
  std::uint64_t seed = 1;
  int train_homes = 48;
  int val_homes = 6;
  int test_homes = 12;
  int groups = 10;  ///< of one to four people, of each home
  int views = 6;    ///< of each group
  int width = 320;
  int height = 192;
  std::optional<std::string> split;  ///< the only one to draw; nothing: all
  int jobs = 1;                      ///< homes at a time
};

/// Draws pictures of people in homes for detectors to learn from: people stand and sit at random
/// places, their size and the colours of their clothes varied, and cameras of 45 to 100 degrees,
/// 0.7 to 2.1 m high, look at them, past them or away. Homes of the three splits differ. People of
/// `test` are those that FigureModel::for_test keeps for tests, those of `val` every sixth of the
/// others; nobody is in two splits.
///
/// Writes `out/{train,val,test}/home-NNNN/{*.jpg,people.json}`; a home whose list is there is left
/// as it is, so that a killed run goes on. The same options and library give the same pictures.
/// @param on_home  called, by one thread at a time, when a home is there or not asked for: how many
///                 are, of how many
/// @throws InputError if it cannot write
void draw_people_pictures(const PeoplePictureOptions& options, const FurnitureLibrary& furniture,
                          const FigureLibrary& figures,
                          const std::function<void(int done, int all)>& on_home);

/// The same person in other clothes: a little taller or shorter, broader or narrower, and all
/// colours but those of skin turned to other hues.
[[nodiscard]] FigureModel varied_figure(const FigureModel& figure, RandomStream& random);

}  // namespace earpoint
