#pragma once

/// earpoint::Vector3, earpoint::Quaternion and earpoint::Pose: x front, y left, z up, metres.
#include <earpoint/core/pose.h>
