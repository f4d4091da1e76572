// The messages of the benchmarks: how they are filled, what changes from message to message, what a subscriber reads.
// The same as in payloads.py.
#pragma once
#include <diagnostic_msgs/DiagnosticArray.h>
#include <geometry_msgs/PoseArray.h>
#include <geometry_msgs/Twist.h>
#include <nav_msgs/Odometry.h>
#include <ros/time.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_msgs/Float64.h>
#include <std_msgs/String.h>
#include <tf2_msgs/TFMessage.h>
#include <visualization_msgs/MarkerArray.h>

#include <string>

// For each type: fill(message, size), change(message, count), read(message).

inline void fill(std_msgs::Float64&, size_t) {}
inline void change(std_msgs::Float64& m, long) { m.data += 0.001; }
inline double read(const std_msgs::Float64& m) { return m.data; }

inline void fill(std_msgs::String&, size_t) {}
inline void change(std_msgs::String& m, long count) {
  static const std::string texts[] = {std::string(100, 'a'), std::string(100, 'b')};
  m.data = texts[count & 1];
}
inline double read(const std_msgs::String& m) { return m.data.size(); }

inline void fill(geometry_msgs::Twist&, size_t) {}
inline void change(geometry_msgs::Twist& m, long) { m.linear.x += 0.001; }
inline double read(const geometry_msgs::Twist& m) { return m.linear.x; }

inline void fill(sensor_msgs::JointState& m, size_t) {
  m.header.frame_id = "base_link";
  for (int i = 0; i < 7; ++i) {
    m.name.push_back("joint_" + std::to_string(i));
    m.position.push_back(0.1 * i);
    m.velocity.push_back(0.2 * i);
    m.effort.push_back(0.3 * i);
  }
}
inline void change(sensor_msgs::JointState& m, long) { m.header.stamp = ros::Time::now(); }
inline double read(const sensor_msgs::JointState& m) { return m.position[0]; }

inline void fill(nav_msgs::Odometry& m, size_t) {
  m.header.frame_id = "odom";
  m.child_frame_id = "base_link";
  m.pose.pose.orientation.w = 1;
}
inline void change(nav_msgs::Odometry& m, long) { m.header.stamp = ros::Time::now(); }
inline double read(const nav_msgs::Odometry& m) { return m.pose.pose.position.x; }

inline void fill(tf2_msgs::TFMessage& m, size_t) {
  for (int i = 0; i < 20; ++i) {
    geometry_msgs::TransformStamped t;
    t.header.frame_id = "base_link";
    t.child_frame_id = "link_" + std::to_string(i);
    t.transform.rotation.w = 1;
    m.transforms.push_back(t);
  }
}
inline void change(tf2_msgs::TFMessage& m, long) { m.transforms[0].header.stamp = ros::Time::now(); }
inline double read(const tf2_msgs::TFMessage& m) { return m.transforms.size(); }

inline void fill(sensor_msgs::Imu& m, size_t) {
  m.header.frame_id = "imu";
  m.orientation.w = 1;
  m.linear_acceleration.z = 9.81;
}
inline void change(sensor_msgs::Imu& m, long) { m.header.stamp = ros::Time::now(); }
inline double read(const sensor_msgs::Imu& m) { return m.linear_acceleration.z; }

inline void fill(sensor_msgs::LaserScan& m, size_t) {
  m.header.frame_id = "laser";
  m.angle_min = -1.5;
  m.angle_max = 1.5;
  m.range_max = 10;
  for (int i = 0; i < 720; ++i) m.ranges.push_back(0.01 * i);
}
inline void change(sensor_msgs::LaserScan& m, long) { m.header.stamp = ros::Time::now(); }
inline double read(const sensor_msgs::LaserScan& m) { return m.ranges.back(); }

inline void fill(geometry_msgs::PoseArray& m, size_t) {
  m.header.frame_id = "map";
  m.poses.resize(100);
  for (size_t i = 0; i < m.poses.size(); ++i) {
    m.poses[i].position.x = 0.1 * i;
    m.poses[i].orientation.w = 1;
  }
}
inline void change(geometry_msgs::PoseArray& m, long) { m.header.stamp = ros::Time::now(); }
inline double read(const geometry_msgs::PoseArray& m) { return m.poses.back().position.x; }

inline void fill(visualization_msgs::MarkerArray& m, size_t) {
  m.markers.resize(100);
  for (size_t i = 0; i < m.markers.size(); ++i) {
    visualization_msgs::Marker& marker = m.markers[i];
    marker.header.frame_id = "map";
    marker.ns = "bench";
    marker.id = i;
    marker.type = visualization_msgs::Marker::SPHERE;
    marker.pose.position.x = 0.1 * i;
    marker.pose.orientation.w = 1;
    marker.scale.x = marker.scale.y = marker.scale.z = 0.1;
    marker.color.a = 1;
  }
}
inline void change(visualization_msgs::MarkerArray& m, long) { m.markers[0].header.stamp = ros::Time::now(); }
inline double read(const visualization_msgs::MarkerArray& m) { return m.markers.back().pose.position.x; }

inline void fill(diagnostic_msgs::DiagnosticArray& m, size_t) {
  for (int i = 0; i < 20; ++i) {
    diagnostic_msgs::DiagnosticStatus status;
    status.name = "bench: device " + std::to_string(i);
    status.message = "OK";
    status.hardware_id = "device " + std::to_string(i);
    for (int j = 0; j < 5; ++j) {
      diagnostic_msgs::KeyValue value;
      value.key = "value " + std::to_string(j);
      value.value = std::to_string(10 * i + j);
      status.values.push_back(value);
    }
    m.status.push_back(status);
  }
}
inline void change(diagnostic_msgs::DiagnosticArray& m, long) { m.header.stamp = ros::Time::now(); }
inline double read(const diagnostic_msgs::DiagnosticArray& m) { return m.status.back().values.back().value.size(); }

inline void fill(sensor_msgs::Image& m, size_t size) {
  m.height = 1;
  m.width = m.step = size;
  m.encoding = "mono8";
  m.data.resize(size);
}
inline void change(sensor_msgs::Image& m, long) { m.header.stamp = ros::Time::now(); }
inline double read(const sensor_msgs::Image& m) { return m.data.size() + 0 * m.data.back(); }

inline void fill(sensor_msgs::PointCloud2& m, size_t size) {
  m.height = 1;
  m.width = size / 16;
  m.point_step = 16;
  m.row_step = size;
  for (int i = 0; i < 3; ++i) {
    sensor_msgs::PointField f;
    f.name = std::string(1, "xyz"[i]);
    f.offset = 4 * i;
    f.datatype = sensor_msgs::PointField::FLOAT32;
    f.count = 1;
    m.fields.push_back(f);
  }
  m.data.resize(size);
}
inline void change(sensor_msgs::PointCloud2& m, long) { m.header.stamp = ros::Time::now(); }
inline double read(const sensor_msgs::PointCloud2& m) { return m.data.size() + 0 * m.data.back(); }
