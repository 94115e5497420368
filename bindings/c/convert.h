#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <optional>

#include "failure.h"

#include <earpoint/earpoint.h>
#include <earpoint/renderer.h>

// From the structs of earpoint.h to the library's types. All throw UsageError for a caller's bug
// and InputError for bad data; `name` is what messages call the argument.
namespace earpoint::c_api {

/// @throws UsageError if `size` is smaller than the struct ever was
/// @throws InputError if members after the `known` bytes are set, which this library does not know
void check_struct_size(const void* bytes, std::size_t size, std::size_t smallest, std::size_t known,
                       const char* name);

/// A struct as this library knows it: members that the caller's version lacks are 0.
/// @param options   of any version; null: all 0
/// @param smallest  its size in the first version that had it
template <typename Options>
Options read_options(const Options* options, std::size_t smallest, const char* name) {
  Options known{};
  if (options == nullptr) return known;
  check_struct_size(options, options->struct_size, smallest, sizeof(Options), name);
  std::memcpy(&known, options, std::min(options->struct_size, sizeof(Options)));
  return known;
}

/// Allocates nothing unless it throws.
Pose pose_from(const earpoint_pose& pose, const char* name);
Image image_from(const earpoint_picture& picture);
Waveform waveform_from(const earpoint_sound& sound);

std::optional<Box> box_from(const earpoint_box* box);
std::optional<Vector3> vector_from(const earpoint_vector3* vector);

RendererOptions renderer_options_from(const earpoint_renderer_options* options);
StreamOptions stream_options_from(const earpoint_stream_options* options);

/// A request with its picture.
struct Request {
  explicit Request(const earpoint_request* request);
  Request(const Request&) = delete;
  Request& operator=(const Request&) = delete;

  Image picture;           ///< empty: none
  RenderRequest contents;  ///< points to the picture
};

}  // namespace earpoint::c_api
