#pragma once

#include <memory>

#include <earpoint/core/image.h>
#include <earpoint/core/random.h>

namespace earpoint {

/// A picture as cameras also take it: a dark one, a covered lens, none (all grey), or one of
/// another place. Each is drawn as often.
/// @param picture  RGB
/// @param other    of another place; returned as it is
[[nodiscard]] std::shared_ptr<const Image> spoilt_picture(const Image& picture,
                                                          std::shared_ptr<const Image> other,
                                                          RandomStream& random);

}  // namespace earpoint
