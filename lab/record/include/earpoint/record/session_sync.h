#pragma once

#include <earpoint/core/progress.h>
#include <earpoint/record/device_sound.h>
#include <earpoint/record/session.h>
#include <earpoint/record/sync.h>

namespace earpoint {

/// synchronize(), and, where the session has boxes, who wears which near microphone: by how its
/// level over the cameras' varies with the distance of who is seen, and by where its voice comes
/// from (match_microphones()). Microphones that are swapped get a line, and so does every one whose
/// wearer the session leaves open.
/// @throws InputError as synchronize(), and if the table of boxes cannot be read
[[nodiscard]] SyncResult synchronize_session(const Session& session, const DeviceSounds& sounds,
                                             ProgressSink& progress);

}  // namespace earpoint
