// The sample messages that every peer builds for itself, field by field, from a seed. interop/peers/samples.py holds the
// same formulas; that equal seeds give equal bytes in every implementation is what the type tests show.
#pragma once

#include <diagnostic_msgs/DiagnosticArray.h>
#include <nav_msgs/GetPlan.h>
#include <nav_msgs/Odometry.h>
#include <rosgraph_msgs/Log.h>
#include <rosgraph_msgs/TopicStatistics.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_msgs/Bool.h>
#include <std_msgs/ByteMultiArray.h>
#include <std_msgs/Duration.h>
#include <std_msgs/Empty.h>
#include <std_msgs/Float32.h>
#include <std_msgs/Float64.h>
#include <std_msgs/Header.h>
#include <std_msgs/Int32MultiArray.h>
#include <std_msgs/Int64.h>
#include <std_msgs/Int8.h>
#include <std_msgs/String.h>
#include <std_msgs/Time.h>
#include <std_msgs/UInt64.h>
#include <std_msgs/UInt8MultiArray.h>
#include <std_srvs/Empty.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>
#include <tf2_msgs/TFMessage.h>
#include <trajectory_msgs/JointTrajectory.h>
#include <visualization_msgs/Marker.h>

#include <limits>
#include <string>

namespace samples {

inline std::string text(long s) { return "Grüße 世界 🤖 " + std::to_string(s); }
inline ros::Time stamp(long s) { return ros::Time(1700000000 + s, 123456789); }
inline ros::Duration span(long s) { return ros::Duration(-s, 500000000); }
inline std::vector<uint8_t> bytes(size_t n) {
  std::vector<uint8_t> out(n);
  for (size_t i = 0; i < n; ++i) out[i] = i % 251;
  return out;
}
template <class Sequence> void count(Sequence& out, long s) {
  long i = 0;
  for (auto& value : out) value = s + i++ / 8.0;
}
template <class Real> std::vector<Real> reals(size_t n, long s) {
  std::vector<Real> out(n);
  count(out, s);
  return out;
}

inline void fill(std_msgs::Empty&, long) {}
inline void fill(std_msgs::Bool& m, long s) { m.data = s % 2; }
inline void fill(std_msgs::Int8& m, long s) { m.data = -(s % 100) - 1; }
inline void fill(std_msgs::Int64& m, long s) { m.data = -(1L << 62) - s; }
inline void fill(std_msgs::UInt64& m, long s) { m.data = (1UL << 63) + s; }
inline void fill(std_msgs::Float32& m, long s) { m.data = s + 0.125; }
inline void fill(std_msgs::Float64& m, long s) { m.data = s + 0.1; }
inline void fill(std_msgs::Time& m, long s) { m.data = stamp(s); }
inline void fill(std_msgs::Duration& m, long s) { m.data = span(s); }
inline void fill(std_msgs::String& m, long s) {
  m.data = s < 0 ? std::string("not UTF-8: \xff\xfe\xe4") : text(s);  // a negative seed: only a C++ program can do that
}
inline void fill(std_msgs::Header& m, long s) {
  m.seq = s;
  m.stamp = stamp(s);
  m.frame_id = "map é " + std::to_string(s);
}
inline void fill(std_msgs::MultiArrayLayout& m, long s) {
  m.dim.resize(2);
  m.dim[0].label = text(s);
  m.dim[0].size = 2;
  m.dim[0].stride = 4;
  m.dim[1].label = "";
  m.dim[1].size = 4294967295u;
  m.data_offset = s;
}
inline void fill(std_msgs::ByteMultiArray& m, long s) {
  fill(m.layout, s);
  m.data = {-128, 0, 127, static_cast<int8_t>(s % 100)};
}
inline void fill(std_msgs::UInt8MultiArray& m, long s) {
  fill(m.layout, s);
  m.data = bytes(300 + s);
}
inline void fill(std_msgs::Int32MultiArray& m, long s) {
  fill(m.layout, s);
  m.data = {std::numeric_limits<int32_t>::min(), static_cast<int32_t>(s), std::numeric_limits<int32_t>::max()};
}
inline void fill(geometry_msgs::Vector3& m, long s) { m.x = s, m.y = s + 0.25, m.z = -s; }
inline void fill(geometry_msgs::Point& m, long s) { m.x = s, m.y = s + 0.25, m.z = -s; }
inline void fill(geometry_msgs::Quaternion& m, long s) { m.x = 0, m.y = s, m.z = 0.5, m.w = 1; }
inline void fill(geometry_msgs::Pose& m, long s) {
  fill(m.position, s);
  fill(m.orientation, s);
}
inline void fill(sensor_msgs::JointState& m, long s) {
  fill(m.header, s);
  m.name = {text(s), "", "joint"};
  m.position = reals<double>(3, s);
  m.velocity = reals<double>(1, -s);
}
inline void fill(sensor_msgs::Imu& m, long s) {
  fill(m.header, s);
  fill(m.orientation, s);
  count(m.orientation_covariance, s);
  fill(m.angular_velocity, s + 1);
  m.angular_velocity_covariance[8] = s;
  fill(m.linear_acceleration, s + 2);
  count(m.linear_acceleration_covariance, -s);
}
inline void fill(sensor_msgs::CameraInfo& m, long s) {
  fill(m.header, s);
  m.height = 480;
  m.width = 640;
  m.distortion_model = "plumb_bob";
  m.D = reals<double>(5, s);
  count(m.K, s);
  count(m.R, s + 1);
  count(m.P, s + 2);
  m.binning_x = 2;
  m.roi.x_offset = s;
  m.roi.do_rectify = true;
}
inline void fill(sensor_msgs::LaserScan& m, long s) {
  fill(m.header, s);
  m.angle_min = -1.5;
  m.angle_max = 1.5;
  m.ranges = reals<float>(100, s);
  m.ranges[7] = std::numeric_limits<float>::infinity();
}
inline void fill(sensor_msgs::PointCloud2& m, long s) {
  fill(m.header, s);
  m.height = 1;
  m.width = 100;
  const char* names[] = {"x", "y", "z"};
  for (uint32_t i = 0; i < 3; ++i) {
    sensor_msgs::PointField field;
    field.name = names[i];
    field.offset = 4 * i;
    field.datatype = sensor_msgs::PointField::FLOAT32;
    field.count = 1;
    m.fields.push_back(field);
  }
  m.point_step = 12;
  m.row_step = 1200;
  m.data = bytes(1200);
  m.is_dense = true;
}
inline void fill(sensor_msgs::Image& m, long s) {  // the seed is the number of bytes
  m.header.frame_id = "camera";
  m.header.stamp = stamp(7);
  m.height = 1;
  m.width = s;
  m.step = s;
  m.encoding = "mono8";
  m.data = bytes(s);
}
inline void fill(nav_msgs::Odometry& m, long s) {
  fill(m.header, s);
  m.child_frame_id = "base_link";
  fill(m.pose.pose, s);
  count(m.pose.covariance, s);
  fill(m.twist.twist.linear, s);
  fill(m.twist.twist.angular, s + 1);
  count(m.twist.covariance, -s);
}
inline void fill(geometry_msgs::TransformStamped& m, long s) {
  fill(m.header, s);
  m.child_frame_id = text(s);
  fill(m.transform.translation, s);
  fill(m.transform.rotation, s);
}
inline void fill(tf2_msgs::TFMessage& m, long s) {
  m.transforms.resize(2);
  fill(m.transforms[0], s);
  fill(m.transforms[1], s + 1);
}
inline void fill(diagnostic_msgs::DiagnosticArray& m, long s) {
  fill(m.header, s);
  m.status.resize(2);
  m.status[0].level = diagnostic_msgs::DiagnosticStatus::WARN;
  m.status[0].name = text(s);
  m.status[0].values.resize(2);
  m.status[0].values[1].key = "ключ";
  m.status[0].values[1].value = "";
  m.status[1].level = diagnostic_msgs::DiagnosticStatus::STALE;
  m.status[1].hardware_id = text(s + 1);
}
inline void fill(visualization_msgs::Marker& m, long s) {
  fill(m.header, s);
  m.ns = text(s);
  m.id = -s;
  m.type = visualization_msgs::Marker::MESH_RESOURCE;
  m.action = visualization_msgs::Marker::DELETEALL;
  fill(m.pose, s);
  fill(m.scale, s);
  m.color.r = 0.5;
  m.color.a = 1;
  m.lifetime = span(s);
  m.frame_locked = true;
  m.points.resize(2);
  fill(m.points[1], s);
  m.colors.resize(1);
  m.colors[0].b = 0.25;
  m.text = text(s + 1);
}
inline void fill(trajectory_msgs::JointTrajectory& m, long s) {
  fill(m.header, s);
  m.joint_names = {"a", text(s)};
  m.points.resize(2);
  m.points[0].positions = reals<double>(2, s);
  m.points[0].time_from_start = ros::Duration(s, 1);
  m.points[1].effort = reals<double>(4, s);
  m.points[1].time_from_start = span(s);
}
inline void fill(rosgraph_msgs::Log& m, long s) {
  fill(m.header, s);
  m.level = rosgraph_msgs::Log::WARN;
  m.name = "/node";
  m.msg = text(s);
  m.line = s;
  m.topics = {"/rosout", ""};
}
inline void fill(rosgraph_msgs::TopicStatistics& m, long s) {
  m.topic = "/t";
  m.window_start = stamp(s);
  m.window_stop = stamp(s + 1);
  m.delivered_msgs = -s;
  m.period_mean = span(s);
  m.stamp_age_max = ros::Duration(s, 999999999);
}

inline void fill(std_srvs::Empty::Request&, long) {}
inline void fill(std_srvs::Trigger::Request&, long) {}
inline void fill(std_srvs::SetBool::Request& m, long s) { m.data = s % 2; }
inline void fill(nav_msgs::GetPlan::Request& m, long s) {
  fill(m.start.header, s);
  fill(m.start.pose, s);
  fill(m.goal.header, s + 1);
  fill(m.goal.pose, s + 1);
  m.tolerance = 0.5;
}

inline void reply(const std_srvs::Empty::Request&, std_srvs::Empty::Response&) {}
inline void reply(const std_srvs::Trigger::Request&, std_srvs::Trigger::Response& out) {
  out.success = true;
  out.message = text(1);
}
inline void reply(const std_srvs::SetBool::Request& in, std_srvs::SetBool::Response& out) {
  out.success = in.data;
  out.message = in.data ? "on — é" : "off";
}
inline void reply(const nav_msgs::GetPlan::Request& in, nav_msgs::GetPlan::Response& out) {
  out.plan.header = in.goal.header;
  out.plan.poses = {in.start, in.goal};
}

}  // namespace samples
