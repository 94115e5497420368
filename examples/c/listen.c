/* Hears a sound file from another place: the whole clip at once, then live on the way there, in
 * blocks of 256 samples. usage: listen IN.wav WHOLE.wav LIVE.wav */
#include <sndfile.h>
#include <stdio.h>
#include <stdlib.h>

#include <earpoint/earpoint.h>

static void check(earpoint_status status) {
  if (status == EARPOINT_OK) return;
  fprintf(stderr, "listen: %s\n", earpoint_last_error());
  exit(status == EARPOINT_INPUT_ERROR ? 2 : 1);
}

static SNDFILE* open_sound(const char* path, int mode, SF_INFO* info) {
  SNDFILE* file = sf_open(path, mode, info);
  if (file != NULL && info->channels == 2) return file;
  fprintf(stderr, "listen: %s: expected a sound of two ears\n", path);
  exit(2);
}

static void write_sound(const char* path, SF_INFO info, const float* left, const float* right) {
  const sf_count_t frames = info.frames; /* sf_open() sets it to 0 */
  info.format = SF_FORMAT_WAV | SF_FORMAT_FLOAT;
  SNDFILE* file = open_sound(path, SFM_WRITE, &info);
  for (sf_count_t i = 0; i < frames; ++i) {
    const float both[] = {left[i], right[i]};
    sf_writef_float(file, both, 1);
  }
  sf_close(file);
}

int main(int argc, char** argv) {
  if (argc != 4) return fprintf(stderr, "usage: listen IN.wav WHOLE.wav LIVE.wav\n"), 2;
  SF_INFO info = {0};
  SNDFILE* file = open_sound(argv[1], SFM_READ, &info);
  const size_t frames = (size_t)info.frames;
  float* memory = malloc(4 * frames * sizeof *memory + 1);
  if (memory == NULL) return fprintf(stderr, "listen: out of memory\n"), 1;
  float* const in[] = {memory, memory + frames};
  float* const out[] = {memory + 2 * frames, memory + 3 * frames};
  float both[2];
  for (size_t i = 0; i < frames && sf_readf_float(file, both, 1) == 1; ++i) {
    in[0][i] = both[0];
    in[1][i] = both[1];
  }
  sf_close(file);

  const float* const ears[] = {in[0], in[1]};
  const earpoint_sound sound = {ears, 2, frames, info.samplerate};
  const earpoint_vector3 mouth = {1.89, 0.2, 0.15}; /* metres in front, to the left, up */
  const earpoint_pose there = {{1.0, -0.5, 0.0}, earpoint_quaternion_from_euler(1.57, 0.0, 0.0)};

  earpoint_renderer* renderer;
  check(earpoint_renderer_open("gtf", NULL, &renderer));
  const earpoint_request request = {
      .struct_size = sizeof request, .speaker_m = &mouth, .target = there};
  check(earpoint_renderer_render(renderer, &sound, &request, out));
  write_sound(argv[2], info, out[0], out[1]);

  const earpoint_stream_options options = {.struct_size = sizeof options,
                                           .sample_rate_hz = info.samplerate};
  earpoint_stream* stream;
  check(earpoint_stream_create(renderer, &options, &stream));
  check(earpoint_stream_place_speaker(stream, &mouth));
  for (size_t at = 0; at < frames; at += 256) {
    const double way = (double)at / (double)frames;
    const earpoint_pose here = {{way, -0.5 * way, 0.0},
                                earpoint_quaternion_from_euler(1.57 * way, 0.0, 0.0)};
    check(earpoint_stream_move_to(stream, &here));
    const float* const block[] = {in[0] + at, in[1] + at};
    float* const there_block[] = {out[0] + at, out[1] + at};
    check(
        earpoint_stream_process(stream, block, there_block, frames - at < 256 ? frames - at : 256));
  }
  write_sound(argv[3], info, out[0], out[1]);
  earpoint_stream_destroy(stream);
  earpoint_renderer_close(renderer);
  free(memory);
  return 0;
}
