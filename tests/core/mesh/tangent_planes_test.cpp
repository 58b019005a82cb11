// SPDX-License-Identifier: BSD-3-Clause
#include "core/mesh/tangent_planes.h"

#include <catch2/catch.hpp>

#include "tests/core/mesh/analytic_scene.h"

using namespace covey;
using namespace covey::mesh;

TEST_CASE("Tangent planes of a plane are that plane, also seen at grazing angles") {
  const DepthCamera camera = make_depth_camera();
  // A street 0.6 m below a level camera.
  const SE3 T_O_C = look_at({0, 0, 0.6}, {5, 0, 0.6});
  const depth_t image = render(camera, T_O_C, plane(Eigen::Vector3d::UnitZ(), 0.0));
  TangentPlanes planes;
  planes.compute(image, camera);
  for (int v = 70; v < camera.camera.height - 2; v += 3) {  // 8 m and nearer
    for (int u = 2; u < camera.camera.width - 2; u += 7) {
      const TangentPlane& found = planes.at(u, v);
      REQUIRE(found.distance > 0.0F);
      CHECK(found.distance == Approx(0.6).epsilon(0.02));
      const Eigen::Vector3d normal_O = T_O_C.rotation * (found.a * found.distance).cast<double>();
      CHECK(normal_O.z() == Approx(-1.0).margin(1e-3));  // from the camera towards the plane
    }
  }
}

TEST_CASE("Planes do not reach across a depth discontinuity and pixels in the air have none") {
  const DepthCamera camera = make_depth_camera();
  depth_t image = render(camera, {}, plane(Eigen::Vector3d::UnitZ(), 6.0));
  const int width = camera.camera.width;
  for (int v = 0; v < camera.camera.height; ++v) {
    for (int u = 0; u < 90; ++u) image.depth_mm[static_cast<std::size_t>(v * width + u)] = 2000;
    image.depth_mm[static_cast<std::size_t>(v * width + 90)] = 4000;  // a mixture of the two
  }
  TangentPlanes planes;
  planes.compute(image, camera);
  CHECK(planes.at(89, 60).distance == Approx(2.0).epsilon(1e-3));
  CHECK(planes.at(90, 60).distance == 0.0F);
  CHECK(planes.at(91, 60).distance == Approx(6.0).epsilon(1e-3));
  CHECK(planes.farthest_m() == Approx(6.0));
}

TEST_CASE("Depths that are missing or out of range have no plane") {
  const DepthCamera camera = make_depth_camera();
  depth_t image = render(camera, {}, plane(Eigen::Vector3d::UnitZ(), 6.0));
  image.depth_mm[0] = 0;
  image.depth_mm[1] = -1;  // 65535 in 16 bits
  image.depth_mm[2] = 200;
  image.depth_mm[3] = 12'500;
  TangentPlanes planes;
  planes.compute(image, camera);
  for (int u = 0; u < 4; ++u) CHECK(planes.at(u, 0).distance == 0.0F);
  CHECK(planes.at(4, 0).distance > 0.0F);
}
