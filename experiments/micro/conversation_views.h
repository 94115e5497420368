#pragma once

#include <cstdint>
#include <vector>

#include <earpoint/camera/camera.h>
#include <earpoint/core/random.h>
#include <earpoint/scene/homes.h>
#include <earpoint/scene/people.h>

namespace earpoint::bench {

/// Two people who talk in a home, and the cameras that see them.
struct ConversationViews {
  Scene scene;  ///< the home with both people
  std::vector<Person> people;
  std::vector<Camera> cameras;
};

/// Draws a conversation: a woman and a man 0.8 to 3 m apart in one room, facing each other, and
/// cameras 1.5 m high on free floor of that room that face the middle between them.
/// @param views   how many cameras
/// @param width, height  of the pictures, pixels
/// @throws InputError if there is no room for them
ConversationViews draw_conversation(const Home& home, const FigureLibrary& figures, int views,
                                    int width, int height, RandomStream& random);

}  // namespace earpoint::bench
