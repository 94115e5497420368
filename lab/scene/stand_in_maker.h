#pragma once

#include <string>

#include <earpoint/scene/furniture.h>

namespace earpoint {

/// Builds one stand-in: depth d_ along x, width w_ along y, height h_, the front at x = d_ / 2.
class StandInMaker {
 public:
  StandInMaker(const Vector3& size_m, const FurnitureStyle& style, SceneBuilder& builder)
      : d_(size_m.x), w_(size_m.y), h_(size_m.z), style_(style), builder_(builder) {}

  void make(FurnitureKind kind);

 private:
  // Surfaces, each stored in the scene at its first use.
  Surface textured(const std::string& key, const std::string& acoustic, TexturePattern pattern,
                   const ScreenColour& colour, float roughness = 0.8F);
  Surface flat(const std::string& key, const std::string& acoustic, const ScreenColour& colour,
               float roughness);
  Surface wood();
  Surface panel();  ///< thin wood that sounds hollow
  Surface upholstery();
  Surface cushion();
  Surface bedding();
  Surface linen();
  Surface metal();
  Surface white();
  Surface ceramic();
  Surface screen();
  Surface plastic();
  Surface stone();
  Surface shade();

  // Parts.
  void box(double x0, double x1, double y0, double y1, double z0, double z1, Surface surface);
  /// Four legs at the corners of the piece.
  void legs(double height_m, double thickness_m, double inset_m, Surface surface);
  /// One picture over the front of the piece, between two heights and inside a rim.
  void front_picture(double z0, double z1, double rim_m, Surface picture);

  void build_bathtub();
  void build_bed();
  void build_blinds();
  void build_bookcase();
  void build_ceiling_lamp();
  void build_chair();
  void build_computer();
  void build_cupboard(int columns, int rows, Surface body);
  void build_curtain();
  void build_framed(Surface picture);
  void build_fridge();
  void build_kitchen_base(bool sink, bool stove);
  void build_lamp(double base_radius_m);
  void build_office_chair();
  void build_piano();
  void build_plant();
  void build_radiator();
  void build_rug();
  void build_seat();
  void build_stool();
  void build_table(double top_m);
  void build_television();
  void build_toilet();
  void build_washbasin();
  void build_washing_machine();

  double d_;
  double w_;
  double h_;
  const FurnitureStyle& style_;
  SceneBuilder& builder_;
};

}  // namespace earpoint
