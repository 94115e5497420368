#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <earpoint/image.h>
#include <earpoint/pose.h>

namespace earpoint {

/// The name that the released loader looks for in every scene's folder.
inline constexpr std::string_view kSoundSpacesMetadata = "cleaned_metadata_v3.json";

/// y_min, y_max, x_min, x_max: the first and the last row, the first and the last column of what
/// is seen, in pixels of 256. Four zeros stand for a speaker who is out of sight: the released
/// loader wants a box for everyone.
using SoundSpacesBox = std::array<int, 4>;

/// One viewpoint of a clip in the SoundSpaces-NVAS layout: numbers as the file has them.
struct SoundSpacesViewpoint {
  Vector3 location;                      ///< their frame: metres, y up
  double rotation_rad = 0.0;             ///< about y, to the left; 0 looks along -z
  std::map<int, std::string> rir;        ///< speaker id -> path of a 2-channel sound
  std::string image;                     ///< path of a PNG
  std::map<int, SoundSpacesBox> bboxes;  ///< by speaker id
};

/// One speaker of a clip. What comes after the location is ours; others' files lack it and their
/// loaders pass over it.
struct SoundSpacesSpeaker {
  int id = 0;
  std::optional<std::string> speech;     ///< "book-chapter-section", or none
  Vector3 location;                      ///< of the mouth
  std::optional<double> rotation_rad{};  ///< where the speaker looks, as for a viewpoint
  std::optional<std::string> gender{};   ///< "female" or "male"
  std::optional<std::string> figure{};   ///< which body
};

/// One conversation in a scene: an item of the data set.
struct SoundSpacesClip {
  std::string scene;
  int index = 0;  ///< within the scene's file
  std::vector<SoundSpacesViewpoint> viewpoints;
  std::vector<SoundSpacesSpeaker> speakers;
};

/// Reads a scene's metadata: a list of clips.
/// @param where  what errors call it, e.g. its file
/// @throws InputError naming the field that is missing or malformed
std::vector<SoundSpacesClip> parse_soundspaces_metadata(std::string_view json,
                                                        const std::string& where,
                                                        const std::string& scene);

/// Writes it: parse_soundspaces_metadata gives the same clips back, to the last bit.
std::string soundspaces_metadata(std::span<const SoundSpacesClip> clips);

/// Where the released loader looks for a recording, below the folder of all speech.
/// @param split   train, or one that begins with val; all others are test
/// @param speech  "book-chapter-section"
/// @throws InputError if the name has another form
std::filesystem::path soundspaces_speech_file(std::string_view split, const std::string& speech);

/// Their frame (y up, -z ahead at rotation 0) as ours (x front, y left, z up).
Vector3 from_soundspaces(const Vector3& location);
Vector3 to_soundspaces(const Vector3& position_m);

/// @return where the pose looks, in [0, 2 pi)
double soundspaces_heading_rad(const Quaternion& orientation);

/// @param box  of a picture of any size; nothing for a speaker out of sight
SoundSpacesBox soundspaces_box(const std::optional<Box>& box);

/// @return the same box; nothing for four zeros
std::optional<Box> from_soundspaces_box(const SoundSpacesBox& box);

}  // namespace earpoint
