#pragma once

#include <memory>

#include <earpoint/core/random.h>
#include <earpoint/dataset/pair_sample.h>
#include <earpoint/image.h>

namespace earpoint {

/// A picture as cameras also take it: a dark one, a covered lens, none (all grey), or one of
/// another place. Each is drawn as often.
/// @param picture  RGB
/// @param other    of another place; returned as it is
[[nodiscard]] std::shared_ptr<const Image> spoilt_picture(const Image& picture,
                                                          std::shared_ptr<const Image> other,
                                                          RandomStream& random);

/// What a camera that sees as far across and takes pictures of 16:9 would have shown: rows above
/// and below are as gtf_view() shows them, and the box ends there.
/// @param sample  its picture and box change
void widen_picture(PairSample& sample);

}  // namespace earpoint
