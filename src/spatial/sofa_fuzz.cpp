#include <cmath>
#include <cstdint>
#include <cstdlib>

#include <fuzz_file.h>
#include <pthread.h>
#include <sys/time.h>

#include <earpoint/error.h>
#include <earpoint/spatial/sofa_file.h>

// Of the sanitizers, where they are linked in.
// NOLINTNEXTLINE(bugprone-reserved-identifier,readability-identifier-naming): their name
extern "C" [[gnu::weak]] void __sanitizer_set_death_callback(void (*callback)());

namespace {

/// Keeps libFuzzer from reporting a crash in the child as a finding, since the parent handles it;
/// and ends a child that loops after 0.2 s of processor time, instead of the 10 s that a user
/// waits.
void prepare_children() {
  pthread_atfork(nullptr, nullptr, [] {
    if (__sanitizer_set_death_callback != nullptr) __sanitizer_set_death_callback(nullptr);
    const itimerval once{.it_interval = {}, .it_value = {.tv_sec = 0, .tv_usec = 200'000}};
    setitimer(ITIMER_PROF, &once, nullptr);
  });
}

}  // namespace

/// Any bytes as a SOFA file: refused with InputError, also where the library that reads it fails in
/// its own process, or read, and then whole and finite.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace earpoint;  // NOLINT(google-build-using-namespace): one function
  [[maybe_unused]] static const bool prepared = (prepare_children(), true);
  const FuzzFile file(data, size);
  try {
    const SofaFile sofa = read_sofa(file.path());
    const std::size_t measurements = sofa.positions_m.size();
    if (sofa.delays_samples.size() != measurements ||
        sofa.responses.size() != measurements * 2 * static_cast<std::size_t>(sofa.taps)) {
      std::abort();
    }
    for (const float value : sofa.responses) {
      if (!std::isfinite(value)) std::abort();
    }
  } catch (const InputError&) {
    return 0;
  }
  return 0;
}
