#pragma once

// Where a movie in the making takes its pictures from. Private to the module.

#include "output_container.h"

#include <filesystem>
#include <memory>

namespace earpoint::ffmpeg {

/// Adds its stream to the movie when made, before OutputContainer::begin().
class PictureWriter {
 public:
  virtual ~PictureWriter() = default;
  /// Writes what is due up to that time.
  /// @throws InputError if the source is damaged or the movie cannot be written
  virtual void write_until(double time_s) = 0;
  /// Writes all that is left.
  virtual void finish() = 0;
};

/// The picture of another movie: copied where an mp4 file may hold it, else encoded again.
/// @param output  must outlive the result
/// @throws InputError if there is no picture
std::unique_ptr<PictureWriter> picture_of_movie(const std::filesystem::path& source,
                                                OutputContainer& output);

}  // namespace earpoint::ffmpeg
