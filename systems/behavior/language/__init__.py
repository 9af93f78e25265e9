"""The language of behavior trees: reading and writing XML.

Every fault in a tree is raised as a BehaviorTreeError with its place.
"""
