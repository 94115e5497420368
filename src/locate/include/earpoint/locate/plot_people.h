#pragma once

#include <filesystem>

#include <earpoint/core/progress.h>
#include <earpoint/image.h>
#include <earpoint/locate/find_people.h>
#include <earpoint/render_files/render.h>

namespace earpoint {

/// Draws a box with its number around everybody, thick and bright around who speaks, with a bar
/// that tells how surely; dashed where somebody is carried on while hidden. A line at the bottom
/// says so when somebody speaks who is not in the picture.
void draw_people(Image& picture, const PeopleFrame& frame);

/// Writes the recording as a movie with boxes drawn, at its picture's own rate (at most 30 a
/// second), a still picture at 5 a second.
/// @param path  .mp4, .m4v or .mov
/// @throws InputError if the recording has no picture, or as MovieWriter
void write_people_movie(const std::filesystem::path& path, const RenderInput& source,
                        const PeopleInClip& people, ProgressSink& progress);

}  // namespace earpoint
