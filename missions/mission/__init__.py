"""Missions: where, when and in which air an aircraft flies, and the scenarios this expands to."""

from missions.mission.mission import Mission as Mission
from missions.mission.scenarios import Scenarios as Scenarios
