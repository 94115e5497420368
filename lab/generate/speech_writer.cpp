#include "speech_writer.h"

#include <system_error>

#include <earpoint/audio/sound_file.h>
#include <earpoint/core/file.h>
#include <earpoint/dataset/soundspaces_metadata.h>
#include <earpoint/error.h>

namespace earpoint {
namespace {

namespace fs = std::filesystem;

void write_speech(const fs::path& path, const Waveform& speech, SpeechForm form) {
  create_folder(path.parent_path());
  if (form == SpeechForm::flac) {
    write_sound(path, speech, SampleFormat::pcm24);
    return;
  }
  // The released loader wants WAV under a name that ends in .flac. Floats, since it does not scale
  // integers.
  fs::path aside = path;
  aside.replace_extension(".wav");
  write_sound(aside, speech, SampleFormat::float32);
  std::error_code error;
  fs::rename(aside, path, error);
  // Another process may have written the same file a moment earlier.
  if (error && !fs::exists(path))
    throw InputError(path.string(), "cannot be renamed into place: " + error.message());
}

}  // namespace

fs::path SpeechWriter::path_of(std::string_view split, const std::string& id) const {
  return folder_ / soundspaces_speech_file(split, id);
}

Waveform SpeechWriter::write(std::string_view split, const SpeechRecording& recording) {
  const fs::path path = path_of(split, recording.id);
  Waveform speech = read_speech(recording.path);
  {
    const std::lock_guard lock(mutex_);
    // Another thread writes the same file.
    if (!begun_.insert(path).second || fs::exists(path)) return speech;
  }
  write_speech(path, speech, form_);
  return speech;
}

void SpeechWriter::write_missing(std::string_view split, const SpeechCorpus& corpus,
                                 const std::string& id) {
  if (!fs::exists(path_of(split, id))) write(split, corpus.recording(id));
}

}  // namespace earpoint
