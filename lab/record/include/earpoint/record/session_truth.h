#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <earpoint/image.h>
#include <earpoint/vector3.h>

namespace earpoint {

/// The clock of a device against session time: what it recorded at its own time c, in seconds since
/// its recording's beginning, happened at
///   t = offset_s + c / (1 + 1e-6 drift_ppm).
/// A clock with a positive drift runs fast. The zero of session time is any: only differences
/// between devices count.
struct DeviceClock {
  std::string name;  ///< of the camera or person in the session
  double offset_s = 0.0;
  double drift_ppm = 0.0;

  friend bool operator==(const DeviceClock&, const DeviceClock&) = default;
};

[[nodiscard]] double session_time_s(const DeviceClock& clock, double device_s);
[[nodiscard]] double device_time_s(const DeviceClock& clock, double session_s);

/// Where somebody is at one time.
struct TrackPoint {
  double time_s = 0.0;   ///< session time
  Vector3 mouth_m;       ///< in the session's world
  double yaw_rad = 0.0;  ///< where the face looks, about z; 0 looks along x

  friend bool operator==(const TrackPoint&, const TrackPoint&) = default;
};

/// A stretch of speech in session time, by energy of the dry voice.
struct SpeechInterval {
  double begin_s = 0.0;
  double end_s = 0.0;

  friend bool operator==(const SpeechInterval&, const SpeechInterval&) = default;
};

struct PersonTruth {
  std::string name;                    ///< as in the session
  std::vector<TrackPoint> track;       ///< ascending times
  std::vector<SpeechInterval> speech;  ///< ascending, not overlapping
};

/// What is known of a simulated session: truth.json.
struct SessionTruth {
  std::vector<DeviceClock> cameras;      ///< in the session's order
  std::vector<DeviceClock> microphones;  ///< of people, in the session's order
  std::vector<PersonTruth> people;       ///< in the session's order
};

/// @throws InputError naming the field that is missing, malformed or not known
[[nodiscard]] SessionTruth read_session_truth(const std::filesystem::path& path);
/// @throws InputError if it cannot be written
void write_session_truth(const std::filesystem::path& path, const SessionTruth& truth);

/// Where a person is seen in one frame of one camera.
struct PersonBox {
  int camera = 0;        ///< index in Session::cameras
  int frame = 0;         ///< of its video, from 0
  double time_s = 0.0;   ///< of that frame on the camera's clock
  int person = 0;        ///< index in Session::people
  Box box;               ///< of the whole body as far as it is in the picture
  double visible = 1.0;  ///< share of the body's pixels that nothing hides, 0 to 1
};

/// boxes.csv beside truth.json: camera,frame,time_s,person,x_min,y_min,x_max,y_max,visible, sorted
/// by camera, frame, person.
/// @throws InputError naming the line
[[nodiscard]] std::vector<PersonBox> read_person_boxes(const std::filesystem::path& path);
/// @throws InputError if it cannot be written
void write_person_boxes(const std::filesystem::path& path, const std::vector<PersonBox>& boxes);

}  // namespace earpoint
