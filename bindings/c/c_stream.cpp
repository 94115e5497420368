#include "convert.h"
#include "failure.h"
#include "handles.h"

#include <limits>

#include <earpoint/renderer.h>
#include <earpoint/stream.h>

using earpoint::c_api::fail_with_literal;
using earpoint::c_api::guarded;
using earpoint::c_api::not_null;

earpoint_status earpoint_stream_create(const earpoint_renderer* renderer,
                                       const earpoint_stream_options* options,
                                       earpoint_stream** stream) {
  return guarded([&] {
    *not_null(stream, "stream") = nullptr;
    *stream =
        new earpoint_stream{not_null(renderer, "renderer")
                                ->renderer.stream(earpoint::c_api::stream_options_from(options))};
  });
}

void earpoint_stream_destroy(earpoint_stream* stream) { delete stream; }

earpoint_status earpoint_stream_see(earpoint_stream* stream, const earpoint_picture* picture,
                                    const earpoint_box* speaker_box) {
  return guarded([&] {
    earpoint::Stream& live = not_null(stream, "stream")->stream;
    const auto box = earpoint::c_api::box_from(speaker_box);
    if (picture == nullptr) {
      live.see_nothing(box);
    } else {
      live.see(earpoint::c_api::image_from(*picture), box);
    }
  });
}

earpoint_status earpoint_stream_place_speaker(earpoint_stream* stream,
                                              const earpoint_vector3* mouth_m) {
  return guarded([&] {
    not_null(stream, "stream")->stream.place_speaker(earpoint::c_api::vector_from(mouth_m));
  });
}

earpoint_status earpoint_stream_move_to(earpoint_stream* stream,
                                        const earpoint_pose* source_from_target) {
  return guarded([&] {
    not_null(stream, "stream")
        ->stream.move_to(earpoint::c_api::pose_from(
            *not_null(source_from_target, "source_from_target"), "source_from_target"));
  });
}

earpoint_status earpoint_stream_process(earpoint_stream* stream, const float* const* in,
                                        float* const* out, size_t frames) {
  // Without exceptions, which allocate: this runs in an audio thread.
  if (stream == nullptr)
    return fail_with_literal(EARPOINT_USAGE_ERROR, "stream: is a null pointer");
  if (frames == 0) return EARPOINT_OK;
  if (in == nullptr || in[0] == nullptr || in[1] == nullptr) {
    return fail_with_literal(EARPOINT_USAGE_ERROR, "in: is a null pointer, or an ear of it is");
  }
  if (out == nullptr || out[0] == nullptr || out[1] == nullptr) {
    return fail_with_literal(EARPOINT_USAGE_ERROR, "out: is a null pointer, or an ear of it is");
  }
  if (frames > std::numeric_limits<std::ptrdiff_t>::max() / sizeof(float)) {
    return fail_with_literal(EARPOINT_USAGE_ERROR, "frames: more than memory holds");
  }
  return guarded([&] { stream->stream.process(in, out, static_cast<std::ptrdiff_t>(frames)); });
}

earpoint_status earpoint_stream_latency(const earpoint_stream* stream, size_t* frames) {
  return guarded([&] {
    *not_null(frames, "frames") =
        static_cast<size_t>(not_null(stream, "stream")->stream.latency_samples());
  });
}

earpoint_status earpoint_stream_speaker(const earpoint_stream* stream, earpoint_vector3* mouth_m,
                                        int* known) {
  return guarded([&] {
    not_null(mouth_m, "mouth_m");
    not_null(known, "known");
    const auto mouth = not_null(stream, "stream")->stream.speaker_m();
    *known = mouth ? 1 : 0;
    if (mouth) *mouth_m = {mouth->x, mouth->y, mouth->z};
  });
}

earpoint_status earpoint_stream_reset(earpoint_stream* stream) {
  return guarded([&] { not_null(stream, "stream")->stream.reset(); });
}
