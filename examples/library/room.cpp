// Traces a room's binaural impulse response and prints its reverberation at each ear.
#include <cstdio>

#include <earpoint/metrics.h>
#include <earpoint/trace.h>

int main() {
  try {
    const earpoint::TraceScene room = earpoint::TraceScene::box({6.0, 4.0, 3.0}, 0.3, 0.5);
    const earpoint::Waveform brir = room.response({.source = {{1.0, 2.0, 1.5}, {}},
                                                   .listener = {{4.0, 1.0, 1.5}, {}},
                                                   .talks = true,
                                                   .duration_s = 0.6});
    for (int ear = 0; ear < brir.channels(); ++ear) {
      const earpoint::Reverberation heard = earpoint::measure_reverberation(brir, ear);
      std::printf("%s ear: T60 %.2f s, C50 %.1f dB\n", ear == 0 ? "left" : "right", heard.t60_s,
                  heard.c50_db);
    }
    return earpoint::compare_sounds(brir, brir).l2 == 0.0 ? 0 : 1;
  } catch (const earpoint::InputError& error) {
    std::fprintf(stderr, "room: %s\n", error.what());
    return 2;
  }
}
