"""Where pytask finds the tasks of the study."""

from dexterity_study.engine.tasks import tasks

globals().update({task.name: task for task in tasks()})
