#pragma once

#include <earpoint/image.h>
#include <earpoint/record/sync.h>

namespace earpoint {

/// A strip for every device over session time: of cameras what is left, in milliseconds, of the
/// times at which voices were heard, of near microphones when their voices were found.
/// @param duration_s  of the session, > 0
/// @return  RGB
[[nodiscard]] Image plot_sync(const SyncResult& result, double duration_s);

}  // namespace earpoint
