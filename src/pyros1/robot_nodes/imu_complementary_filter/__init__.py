"""imu_complementary_filter: the orientation of an IMU by a complementary filter
(https://wiki.ros.org/imu_complementary_filter).
"""
