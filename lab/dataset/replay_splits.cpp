#include <earpoint/dataset/replay_splits.h>

#include <earpoint/error.h>

namespace earpoint {

std::vector<std::string_view> replay_scenes(const std::string& split) {
  if (split == "train") {
    return {"SC-1022", "SC-1023", "SC-1024", "SC-1025", "SC-1032", "SC-1033", "SC-1035", "SC-1036",
            "SC-1040", "SC-1042", "SC-1045", "SC-1047", "SC-1048", "SC-1049", "SC-1050", "SC-1059",
            "SC-1066", "SC-1069", "SC-1070", "SC-1071", "SC-1075", "SC-1076", "SC-1077", "SC-1078",
            "SC-1079", "SC-1081", "SC-1085", "SC-1087", "SC-1090", "SC-1091", "SC-1101", "SC-1102",
            "SC-1104", "SC-1105", "SC-1106", "SC-1108"};
  }
  if (split == "val") return {"SC-1026", "SC-1054", "SC-1073", "SC-1082", "SC-1092", "SC-1103"};
  if (split == "test") {
    return {"SC-1027", "SC-1044", "SC-1052", "SC-1074", "SC-1084", "SC-1093", "SC-1107"};
  }
  throw InputError("split '" + split + "'", "is not known", "use train, val or test");
}

}  // namespace earpoint
