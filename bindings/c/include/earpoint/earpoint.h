#pragma once

/// Earpoint from C (C99): renders a recorded moment at another position, as whole clips or live.
/// examples/c is a complete program, docs/c.md the guide. Link libearpoint (pkg-config earpoint).
///
/// Frame: x front, y left, z up, right-handed, metres; angles in radians. Samples: planar float32,
/// left ear first. No function throws, prints or exits.
///
/// Every function that can fail returns a status. The text of the last failure in the calling
/// thread is earpoint_last_error(). After a failure results are as before, handles are usable, and
/// a handle that was to be made is null.
///
/// Options are structs that start with their size, so that later versions can add members at the
/// end. Set struct_size to sizeof the struct and all else to 0: a member that is 0 or null has
/// its default. A null pointer to options means defaults.

#include <stddef.h>
#include <stdint.h>

#include <earpoint/export.h>
#include <earpoint/version.h>

#ifdef __cplusplus
extern "C" {
#endif

/// What became of a call.
typedef enum earpoint_status {
  EARPOINT_OK = 0,
  /// Bad data from outside: a file, sound, position. The text is fit to be shown to a user.
  EARPOINT_INPUT_ERROR = 1,
  /// A caller's bug: a null pointer, three channels, a struct without its size.
  EARPOINT_USAGE_ERROR = 2,
  EARPOINT_OUT_OF_MEMORY = 3,
  EARPOINT_INTERNAL_ERROR = 4,  ///< any other failure
} earpoint_status;

/// Why the last call that failed in this thread did: one line, "where: problem; hint". Empty if
/// none has failed. Valid until the next call that fails in this thread.
EARPOINT_API const char* earpoint_last_error(void);

/// The version of these headers as one number: 10000 * major + 100 * minor + patch.
#define EARPOINT_VERSION_NUMBER \
  (10000 * EARPOINT_VERSION_MAJOR + 100 * EARPOINT_VERSION_MINOR + EARPOINT_VERSION_PATCH)

/// The version of the library that runs, e.g. "0.1.0".
EARPOINT_API const char* earpoint_version(void);
/// The same in the form of EARPOINT_VERSION_NUMBER.
EARPOINT_API int earpoint_version_number(void);

/// A list of texts. Texts belong to the list.
typedef struct earpoint_strings earpoint_strings;

/// Number of texts; 0 if the list is null.
EARPOINT_API size_t earpoint_strings_count(const earpoint_strings* strings);
/// A text, from index 0; null if there is none.
EARPOINT_API const char* earpoint_strings_at(const earpoint_strings* strings, size_t index);
/// A null list is ignored.
EARPOINT_API void earpoint_strings_destroy(earpoint_strings* strings);

/// The names of the installed models, sorted, e.g. "enhance", "gtf". docs/library.md says where
/// they are searched.
/// @param models  receives the list, to be destroyed by the caller
EARPOINT_API earpoint_status earpoint_installed_models(earpoint_strings** models);

/// What a model can do.
/// @param model    the name of an installed model, or a weight file
/// @param renders  receives 1 if earpoint_renderer_open() takes it, else 0; may be null
/// @param streams  receives 1 if earpoint_stream_create() does, else 0; may be null
/// @return EARPOINT_INPUT_ERROR if there is no such model, or it is not a known weight file
EARPOINT_API earpoint_status earpoint_describe_model(const char* model, int* renders, int* streams);

/// A point, metres.
typedef struct earpoint_vector3 {
  double x;
  double y;
  double z;
} earpoint_vector3;

/// A rotation as a unit quaternion, w + xi + yj + zk; all zero: none.
typedef struct earpoint_quaternion {
  double w;
  double x;
  double y;
  double z;
} earpoint_quaternion;

/// A head's turn, applied in the order roll, pitch, yaw. Radians; positive yaw turns to the left,
/// positive pitch looks up, positive roll lowers the right ear.
EARPOINT_API earpoint_quaternion earpoint_quaternion_from_euler(double yaw_rad, double pitch_rad,
                                                                double roll_rad);

/// A head in the source's frame.
typedef struct earpoint_pose {
  earpoint_vector3 position_m;
  earpoint_quaternion orientation;
} earpoint_pose;

/// A rectangle in a picture, normalised: x grows to the right, y downwards, both in [0, 1].
typedef struct earpoint_box {
  double x_min;
  double y_min;
  double x_max;
  double y_max;
} earpoint_box;

/// A picture in the caller's memory, read during the call only: 8 bits per channel, sRGB.
typedef struct earpoint_picture {
  const uint8_t* rgb;  ///< [height][width][3], top row first
  int width;
  int height;
  size_t row_bytes;  ///< from one row to the next; 0: 3 * width
} earpoint_picture;

/// Sound in the caller's memory, read during the call only.
typedef struct earpoint_sound {
  const float* const* channels;  ///< [channel_count][frames]
  int channel_count;             ///< 2: ears, left first. 1: the voice is placed at the speaker
  size_t frames;                 ///< at least 0.1 s
  int sample_rate_hz;            ///< 16000 or more
} earpoint_sound;

/// A point on the path of a moving earpoint.
typedef struct earpoint_path_point {
  double time_s;  ///< since the sound's beginning
  earpoint_pose source_from_target;
} earpoint_path_point;

/// Options of a model.
typedef struct earpoint_renderer_options {
  size_t struct_size;
  double horizontal_fov_rad;  ///< field of view of the source's camera; 0: 90 degrees
  /// For gtf networks trained for both textures: 1 natural, 0 the mean. Null: natural.
  const double* texture;
  const char* hrtf;  ///< head filters of "dsp", a SOFA file; null: the KEMAR set of libmysofa
  int threads;       ///< 0: one; the samples are the same for any number
} earpoint_renderer_options;

/// What is known of a recorded moment, and the earpoint.
typedef struct earpoint_request {
  size_t struct_size;
  const earpoint_picture* picture;  ///< of the source's camera; null: none
  /// Box of the speaker in the picture, and position of their mouth, metres in the source's frame.
  /// Both null: the network locates the speaker by picture and sound, if it can.
  const earpoint_box* speaker_box;
  const earpoint_vector3* speaker_m;  ///< see speaker_box
  earpoint_pose target;               ///< the earpoint: its head in the source's frame
  /// Instead of the target, for a moving earpoint: ascending times, from 0 to the sound's end.
  const earpoint_path_point* path;
  size_t path_count;      ///< points of the path
  double gain_db;         ///< of the output, before the limiter; -100 to 100
  int no_band_extension;  ///< not 0: sound above the model's band is removed
  int no_limiter;         ///< not 0: the output may exceed full scale
} earpoint_request;

/// A model that renders. One caller at a time; different renderers share nothing.
typedef struct earpoint_renderer earpoint_renderer;

/// Opens a model.
/// @param model     the name of an installed model, a weight file, "dsp" or "input"; null: "gtf"
/// @param options   may be null
/// @param renderer  receives the handle, to be closed by the caller
/// @return EARPOINT_INPUT_ERROR if there is no such model, it makes no sound, or it cannot have
///         these options
EARPOINT_API earpoint_status earpoint_renderer_open(const char* model,
                                                    const earpoint_renderer_options* options,
                                                    earpoint_renderer** renderer);
/// A null renderer is ignored. Streams made by it may live on.
EARPOINT_API void earpoint_renderer_close(earpoint_renderer* renderer);

/// The weight file in use, or "dsp" or "input"; valid as long as the renderer. Null for null.
EARPOINT_API const char* earpoint_renderer_model(const earpoint_renderer* renderer);

/// Renders a whole clip.
/// @param request  null: no picture, unknown speaker, at the source itself
/// @param out      two ears, [2][frames] at the sound's rate; may be the memory of the sound
/// @return EARPOINT_INPUT_ERROR if the sound is too short, of a lower rate, silent, or has NaN; if
///         the model needs a picture or a speaker and none is given; if the path does not cover
///         the sound. EARPOINT_USAGE_ERROR for other channel counts than 1 and 2
EARPOINT_API earpoint_status earpoint_renderer_render(earpoint_renderer* renderer,
                                                      const earpoint_sound* sound,
                                                      const earpoint_request* request,
                                                      float* const* out);

/// What is outside the model's training data: messages, a line each.
/// @param sound, request  as earpoint_renderer_render() takes them
/// @param warnings        receives the list, to be destroyed by the caller
EARPOINT_API earpoint_status earpoint_renderer_warnings(const earpoint_renderer* renderer,
                                                        const earpoint_sound* sound,
                                                        const earpoint_request* request,
                                                        earpoint_strings** warnings);

/// Options of a stream.
typedef struct earpoint_stream_options {
  size_t struct_size;
  int sample_rate_hz;     ///< from 16000 to 192000, a multiple of 50; 0: 48000
  int no_band_extension;  ///< not 0: sound above the network's band is removed; gtf only
  int no_limiter;         ///< not 0: the output may exceed full scale
  /// Rounds that make the phases of frames consistent; each adds 20 ms of latency. Null: as many
  /// as the network was trained with, which is the most; "dsp" has none.
  const int* phase_rounds;
} earpoint_stream_options;

/// Live sound at an earpoint, block by block. Calls on a stream must not overlap: one thread at a
/// time, or with the caller's lock. Different streams share nothing.
typedef struct earpoint_stream earpoint_stream;

/// Starts rendering live sound.
/// @param options  may be null
/// @param stream   receives the handle, to be destroyed by the caller
/// @return EARPOINT_INPUT_ERROR if the sample rate or the phase rounds are not supported, or the
///         model is neither a gtf network nor "dsp"
EARPOINT_API earpoint_status earpoint_stream_create(const earpoint_renderer* renderer,
                                                    const earpoint_stream_options* options,
                                                    earpoint_stream** stream);
/// A null stream is ignored.
EARPOINT_API void earpoint_stream_destroy(earpoint_stream* stream);

/// The source camera's picture from here on. Computes and allocates: not for the audio thread.
/// @param picture      null: unknown, as at the start
/// @param speaker_box  box of the speaker in the camera's picture; null: unknown. "dsp" has no use
///                     for a box without a picture: EARPOINT_INPUT_ERROR
EARPOINT_API earpoint_status earpoint_stream_see(earpoint_stream* stream,
                                                 const earpoint_picture* picture,
                                                 const earpoint_box* speaker_box);

/// Position of the speaker's mouth. Allocates nothing unless it fails.
/// @param mouth_m  metres in the source's frame; null: located by picture and sound
EARPOINT_API earpoint_status earpoint_stream_place_speaker(earpoint_stream* stream,
                                                           const earpoint_vector3* mouth_m);

/// The earpoint from here on. Allocates nothing unless it fails.
/// @param source_from_target  its head in the source's frame
EARPOINT_API earpoint_status earpoint_stream_move_to(earpoint_stream* stream,
                                                     const earpoint_pose* source_from_target);

/// Renders the next samples. Allocates nothing and takes no lock.
/// @param in      left and right ear of the source, [2][frames]; NaN and infinity count as 0
/// @param out     left and right ear of the earpoint, [2][frames], late by the stream's latency;
///                may be the memory of `in`
/// @param frames  may change with every call
EARPOINT_API earpoint_status earpoint_stream_process(earpoint_stream* stream,
                                                     const float* const* in, float* const* out,
                                                     size_t frames);

/// Latency of the output for any block size.
/// @param frames  receives samples at the stream's rate
EARPOINT_API earpoint_status earpoint_stream_latency(const earpoint_stream* stream, size_t* frames);

/// Estimated position of the speaker's mouth.
/// @param mouth_m  receives metres in the source's frame; untouched if unknown
/// @param known    receives 0 before the first sound and if "dsp" was told nothing, else 1
EARPOINT_API earpoint_status earpoint_stream_speaker(const earpoint_stream* stream,
                                                     earpoint_vector3* mouth_m, int* known);

/// Restarts from silence; picture, speaker and earpoint are kept.
EARPOINT_API earpoint_status earpoint_stream_reset(earpoint_stream* stream);

#ifdef __cplusplus
}
#endif
